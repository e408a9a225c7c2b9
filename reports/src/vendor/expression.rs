//! Formulas of counters: numbers, names, `+ - * /`, a sign, and parentheses, with the usual precedence.
//!
//! A formula is read once into steps of a stack machine, so that evaluating one needs no recursion. Length and nesting are bounded:
//! no text can exhaust the stack.

use std::fmt;

/// Most bytes of a formula.
const LONGEST: usize = 1000;
/// Most parentheses and signs within each other.
const DEEPEST: usize = 50;

/// A formula that has been read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Expression {
    /// In the order of a stack machine: operands before their operator.
    steps: Vec<Step>,
}

#[derive(Clone, Debug, PartialEq)]
enum Step {
    Number(f64),
    Name(String),
    Negate,
    Binary(Operator),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// What is wrong with a formula.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Mistake {
    /// Characters before it.
    at: usize,
    expected: &'static str,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected {} at character {}", self.expected, self.at + 1)
    }
}

impl Expression {
    pub(super) fn parse(text: &str) -> Result<Self, Mistake> {
        if text.len() > LONGEST {
            return Err(Mistake {
                at: LONGEST,
                expected: "the end, for a formula has at most 1000 characters",
            });
        }
        let mut reader = Reader { text, at: 0, depth: 0, steps: Vec::new() };
        reader.sum()?;
        match reader.peek() {
            None => Ok(Self { steps: reader.steps }),
            Some(_) => Err(reader.mistake("an operator or the end")),
        }
    }

    /// The names in it, in their order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().filter_map(|step| match step {
            Step::Name(name) => Some(name.as_str()),
            _ => None,
        })
    }

    /// The name, where the formula is nothing else.
    pub(super) fn only_name(&self) -> Option<&str> {
        match self.steps.as_slice() {
            [Step::Name(name)] => Some(name),
            _ => None,
        }
    }

    /// The figure, with each name's value from `value`.
    ///
    /// # Errors
    /// Why there is no figure: what `value` says of a name, or a division by zero, or a figure beyond what a number can hold.
    pub(super) fn evaluate(&self, value: impl Fn(&str) -> Result<f64, String>) -> Result<f64, String> {
        let mut stack: Vec<f64> = Vec::new();
        let pop = |stack: &mut Vec<f64>| stack.pop().expect("operands stand before their operator");
        for step in &self.steps {
            let result = match step {
                Step::Number(number) => *number,
                Step::Name(name) => value(name)?,
                Step::Negate => -pop(&mut stack),
                Step::Binary(operator) => {
                    let right = pop(&mut stack);
                    let left = pop(&mut stack);
                    match operator {
                        Operator::Add => left + right,
                        Operator::Subtract => left - right,
                        Operator::Multiply => left * right,
                        Operator::Divide if right == 0.0 => {
                            return Err("there is nothing to divide by".to_owned());
                        }
                        Operator::Divide => left / right,
                    }
                }
            };
            stack.push(result);
        }
        let figure = pop(&mut stack);
        if figure.is_finite() {
            Ok(figure)
        } else {
            Err("the figure is beyond what a number can hold".to_owned())
        }
    }
}

struct Reader<'a> {
    text: &'a str,
    /// Bytes read, always at the border of a character.
    at: usize,
    depth: usize,
    steps: Vec<Step>,
}

impl Reader<'_> {
    fn sum(&mut self) -> Result<(), Mistake> {
        self.product()?;
        while let Some(operator) = self.operator(&[('+', Operator::Add), ('-', Operator::Subtract)]) {
            self.product()?;
            self.steps.push(Step::Binary(operator));
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), Mistake> {
        self.factor()?;
        while let Some(operator) = self.operator(&[('*', Operator::Multiply), ('/', Operator::Divide)]) {
            self.factor()?;
            self.steps.push(Step::Binary(operator));
        }
        Ok(())
    }

    fn factor(&mut self) -> Result<(), Mistake> {
        const OPERAND: &str = "a number, a name, a sign or '('";
        match self.peek() {
            Some('(') => self.within(|reader| {
                reader.sum()?;
                if reader.take(')') { Ok(()) } else { Err(reader.mistake("')'")) }
            }),
            Some('-') => self.within(|reader| {
                reader.factor()?;
                reader.steps.push(Step::Negate);
                Ok(())
            }),
            Some(first) if first.is_ascii_digit() => {
                let word = self.word(|letter| letter.is_ascii_digit() || letter == '.');
                let number = word.parse().map_err(|_| self.mistake("a number such as 12.5 before this"))?;
                self.steps.push(Step::Number(number));
                Ok(())
            }
            Some(first) if first.is_ascii_lowercase() => {
                let word = self
                    .word(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_');
                self.steps.push(Step::Name(word));
                Ok(())
            }
            _ => Err(self.mistake(OPERAND)),
        }
    }

    /// Reads on behind one character, one level deeper.
    fn within(&mut self, read: impl FnOnce(&mut Self) -> Result<(), Mistake>) -> Result<(), Mistake> {
        if self.depth == DEEPEST {
            return Err(self.mistake("no more than 50 parentheses and signs within each other"));
        }
        self.depth += 1;
        self.at += 1;
        read(self)?;
        self.depth -= 1;
        Ok(())
    }

    fn operator(&mut self, known: &[(char, Operator)]) -> Option<Operator> {
        let &(_, operator) = known.iter().find(|(sign, _)| self.take(*sign))?;
        Some(operator)
    }

    /// The next character that is no blank.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, sign: char) -> bool {
        let there = self.peek() == Some(sign);
        self.at += if there { sign.len_utf8() } else { 0 };
        there
    }

    fn word(&mut self, belongs: impl Fn(char) -> bool) -> String {
        let rest = &self.text[self.at..];
        let end = rest.find(|letter| !belongs(letter)).unwrap_or(rest.len());
        self.at += end;
        rest[..end].to_owned()
    }

    fn mistake(&self, expected: &'static str) -> Mistake {
        Mistake { at: self.text[..self.at].chars().count(), expected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(name: &str) -> Result<f64, String> {
        match name {
            "two" => Ok(2.0),
            "zero" => Ok(0.0),
            "huge" => Ok(1e308),
            _ => Err(format!("{name} is not there")),
        }
    }

    fn evaluated(text: &str) -> Result<f64, String> {
        Expression::parse(text).map_err(|mistake| mistake.to_string())?.evaluate(value)
    }

    #[test]
    fn operators_bind_as_usual_and_from_the_left() {
        for (text, expected) in [
            ("1", 1.0),
            (" 12.5 ", 12.5),
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("10 - 4 - 3", 3.0),
            ("16 / 4 / 2", 2.0),
            ("16 / (4 / 2)", 8.0),
            ("2 * -two", -4.0),
            ("--two", 2.0),
            ("-two + 3", 1.0),
            ("100 * two / (two * 1000 / 1000)", 100.0),
        ] {
            assert_eq!(evaluated(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_formula_is_refused_with_its_place() {
        for (text, message) in [
            ("", "expected a number, a name, a sign or '(' at character 1"),
            ("1 +", "expected a number, a name, a sign or '(' at character 4"),
            ("1 2", "expected an operator or the end at character 3"),
            ("(1", "expected ')' at character 3"),
            ("1)", "expected an operator or the end at character 2"),
            ("1.2.3", "expected a number such as 12.5 before this at character 6"),
            ("Two", "expected a number, a name, a sign or '(' at character 1"),
            ("two % 3", "expected an operator or the end at character 5"),
            ("é", "expected a number, a name, a sign or '(' at character 1"),
        ] {
            assert_eq!(evaluated(text), Err(message.to_owned()), "{text}");
        }
    }

    #[test]
    fn nesting_and_length_are_bounded_on_both_sides() {
        let nested = |depth: usize| format!("{}1{}", "(".repeat(depth), ")".repeat(depth));
        assert_eq!(evaluated(&nested(DEEPEST)), Ok(1.0));
        assert!(evaluated(&nested(DEEPEST + 1)).is_err_and(|message| message.contains("no more than 50")));
        assert!(evaluated(&"-".repeat(900)).is_err_and(|message| message.contains("no more than 50")));
        let long = format!("1{}", "+1".repeat(499));
        assert_eq!(evaluated(&format!("{long} ")), Ok(500.0));
        assert!(evaluated(&format!("{long}  ")).is_err_and(|message| message.contains("at most 1000")));
    }

    #[test]
    fn there_is_a_reason_where_there_is_no_figure() {
        assert_eq!(evaluated("two + three"), Err("three is not there".to_owned()));
        assert_eq!(evaluated("two / zero"), Err("there is nothing to divide by".to_owned()));
        assert_eq!(evaluated("zero / zero"), Err("there is nothing to divide by".to_owned()));
        assert!(evaluated("huge * two").is_err_and(|reason| reason.contains("beyond")));
        assert!(evaluated(&format!("1{}", "0".repeat(400))).is_err_and(|reason| reason.contains("beyond")));
    }

    #[test]
    fn any_text_is_read_or_refused() {
        // Every text of up to five of these characters.
        let letters = ['(', ')', '-', '/', '1', 'a', '.', ' ', 'ß'];
        for length in 0..=5_u32 {
            for number in 0..letters.len().pow(length) {
                let letter = |place| letters[number / letters.len().pow(place) % letters.len()];
                let text: String = (0..length).map(letter).collect();
                if let Ok(expression) = Expression::parse(&text) {
                    let figure = expression.evaluate(|_| Ok(3.0));
                    assert!(figure.is_err() || figure.is_ok_and(f64::is_finite), "{text}");
                }
            }
        }
    }

    #[test]
    fn names_are_found() {
        let expression = Expression::parse("100 * l2_misses / (l2_misses + rays)").expect("a formula");
        assert_eq!(expression.names().collect::<Vec<_>>(), ["l2_misses", "l2_misses", "rays"]);
        assert_eq!(expression.only_name(), None);
        assert_eq!(Expression::parse(" (rays) ").expect("a formula").only_name(), Some("rays"));
    }
}
