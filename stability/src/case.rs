//! What a case says: what was expected, what came out, how far apart.

/// What a figure has to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
}

/// A figure that says how hard a case is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// What it is.
    pub what: &'static str,
    /// How much of it.
    pub value: f64,
}

/// A case, carried out.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its name, unique.
    pub id: String,
    /// What must hold.
    pub statement: String,
    /// What `found` counts or measures.
    pub unit: &'static str,
    /// What was expected.
    pub limit: Limit,
    /// What came out.
    pub found: f64,
    /// The largest condition met, where there is one.
    pub condition: Option<Condition>,
    /// Largest relative residual of what was solved.
    pub residual: Option<f64>,
    /// What else there is to say; where it fails, the reason.
    pub why: String,
}

impl Case {
    /// A case without a condition, residual or remark.
    pub fn new(
        id: impl Into<String>,
        statement: impl Into<String>,
        unit: &'static str,
        limit: Limit,
        found: f64,
    ) -> Self {
        let (id, statement) = (id.into(), statement.into());
        Self { id, statement, unit, limit, found, condition: None, residual: None, why: String::new() }
    }

    /// A case whose `found` counts what must not happen.
    pub fn none_of(
        id: impl Into<String>,
        statement: impl Into<String>,
        unit: &'static str,
        found: u64,
    ) -> Self {
        Self::new(id, statement, unit, Limit::AtMost(0.0), found as f64)
    }

    /// The same with a condition.
    #[must_use]
    pub fn under(self, what: &'static str, value: f64) -> Self {
        Self { condition: Some(Condition { what, value }), ..self }
    }

    /// The same with a residual.
    #[must_use]
    pub fn with_residual(self, residual: f64) -> Self {
        Self { residual: Some(residual), ..self }
    }

    /// The same with a remark.
    #[must_use]
    pub fn because(self, why: impl Into<String>) -> Self {
        Self { why: why.into(), ..self }
    }

    /// How far what came out is beyond its limit, in units of `found`; below 0 it is that far from it.
    pub fn beyond(&self) -> f64 {
        match self.limit {
            Limit::AtMost(limit) => self.found - limit,
            Limit::AtLeast(limit) => limit - self.found,
        }
    }

    /// Whether the limit is kept. A NaN keeps none.
    pub fn passes(&self) -> bool {
        self.beyond() <= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_kept_at_its_value_and_not_beyond() {
        let case = |limit, found| Case::new("id", "statement", "unit", limit, found).passes();
        assert!(case(Limit::AtMost(2.0), 2.0) && !case(Limit::AtMost(2.0), 2.0_f64.next_up()));
        assert!(case(Limit::AtLeast(2.0), 2.0) && !case(Limit::AtLeast(2.0), 2.0_f64.next_down()));
        assert!(!case(Limit::AtMost(2.0), f64::NAN) && !case(Limit::AtLeast(2.0), f64::NAN));
    }
}
