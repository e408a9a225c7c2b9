//! Text as HTML, and tables.

use crate::counters::Value;
use crate::units;
use gpumodel::CounterInfo;
use std::fmt;

/// Text that a page shows as it is, in content and in quoted attributes.
pub(super) struct Escaped<'a>(pub(super) &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                letter => fmt::Write::write_char(f, letter)?,
            }
        }
        Ok(())
    }
}

/// A table whose rows a reader can sort and filter, by group.
pub(super) struct Table {
    /// What it shows, for those who do not see it.
    pub(super) label: String,
    pub(super) columns: Vec<Column>,
    pub(super) groups: Vec<Group>,
    /// Whether it is long enough to be worth a filter.
    pub(super) filter: bool,
}

/// The head of a column.
pub(super) struct Column {
    title: String,
    figures: bool,
}

/// Rows under a title, or under none.
pub(super) struct Group {
    pub(super) title: Option<String>,
    pub(super) rows: Vec<Vec<Cell>>,
}

pub(super) enum Cell {
    Words(String),
    /// A name with what it means, and with the colour of a series where a chart beside the table shows it.
    Name {
        name: String,
        about: Vec<(&'static str, String)>,
        series: Option<usize>,
    },
    /// As shown, what rows are sorted by, and every digit. A unit, be it empty, where figures of the column differ in theirs.
    Figure {
        shown: String,
        unit: Option<String>,
        value: f64,
        exact: String,
    },
    /// No figure, and why.
    Absent(String),
}

impl Group {
    /// Adds a row under a title.
    pub(super) fn add(groups: &mut Vec<Self>, title: &str, row: Vec<Cell>) {
        match groups.iter_mut().find(|group| group.title.as_deref() == Some(title)) {
            Some(group) => group.rows.push(row),
            None => groups.push(Self { title: Some(title.to_owned()), rows: vec![row] }),
        }
    }
}

impl Column {
    pub(super) fn words(title: &str) -> Self {
        Self { title: title.to_owned(), figures: false }
    }

    pub(super) fn figures(title: &str) -> Self {
        Self { title: title.to_owned(), figures: true }
    }
}

impl Cell {
    pub(super) fn name(name: &str, series: usize) -> Self {
        Self::Name { name: name.to_owned(), about: Vec::new(), series: Some(series) }
    }

    /// A counter's name with its definition.
    pub(super) fn counter_name(info: &CounterInfo) -> Self {
        let about =
            [("Formula", info.formula), ("Unit", info.unit), ("Per", info.denominator), ("Id", info.id)];
        let about = about.into_iter().filter(|(_, text)| !text.is_empty());
        let about = about.map(|(what, text)| (what, text.to_owned())).collect();
        Self::Name { name: info.name.to_owned(), about, series: None }
    }

    /// A counter's figure with its unit.
    pub(super) fn counter(value: &Value, unit: &str) -> Self {
        let exact = match value {
            Value::Count(count) => count.to_string(),
            Value::Real(real) => real.to_string(),
            Value::Absent { reason } => return Self::Absent(reason.clone()),
        };
        let (shown, scaled) = units::scaled(value, unit).expect("what is not absent is a figure");
        let value = value.as_f64().expect("what is not absent is a figure");
        Self::Figure { shown, unit: Some(scaled), value, exact: format!("{exact} {unit}") }
    }

    /// With its unit in the head of its column.
    fn without_unit(value: &Value) -> Self {
        match Self::counter(value, "") {
            Self::Figure { shown, value, exact, .. } => Self::Figure { shown, unit: None, value, exact },
            other => other,
        }
    }

    pub(super) fn bytes(bytes: u64) -> Self {
        Self::counter(&Value::Count(bytes), "B")
    }

    pub(super) fn count(count: u64) -> Self {
        Self::without_unit(&Value::Count(count))
    }

    /// A number whose unit stands in the head of its column.
    pub(super) fn number(number: f64) -> Self {
        Self::without_unit(&Value::Real(number))
    }

    /// A part of a whole, with one decimal; its unit stands in the head of its column.
    pub(super) fn per_cent(part: f64) -> Self {
        let value = 100.0 * part;
        Self::Figure { shown: format!("{value:.1}"), unit: None, value, exact: format!("{value} %") }
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { label, columns, groups, filter } = self;
        let label = Escaped(label);
        let filter = if *filter { " data-filter" } else { "" };
        write!(
            f,
            "<div class=\"scroll\" role=\"region\" aria-label=\"{label}\" tabindex=\"0\"{filter}><table>"
        )?;
        f.write_str("<thead><tr>")?;
        for Column { title, figures } in columns {
            let class = if *figures { " class=\"n\"" } else { "" };
            write!(f, "<th scope=\"col\"{class}>{}</th>", Escaped(title))?;
        }
        f.write_str("</tr></thead>")?;
        for Group { title, rows } in groups {
            f.write_str("<tbody>")?;
            if let Some(title) = title {
                let span = columns.len();
                write!(
                    f,
                    "<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{span}\"><span>{}</span></th></tr>",
                    Escaped(title)
                )?;
            }
            for row in rows {
                f.write_str("<tr>")?;
                row.iter().enumerate().try_for_each(|(index, cell)| cell.write(f, index == 0))?;
                f.write_str("</tr>")?;
            }
            f.write_str("</tbody>\n")?;
        }
        f.write_str("</table></div>\n")
    }
}

impl Cell {
    fn write(&self, f: &mut fmt::Formatter<'_>, heads: bool) -> fmt::Result {
        let (open, close) = if heads { ("th scope=\"row\"", "th") } else { ("td", "td") };
        match self {
            Self::Words(words) => write!(f, "<{open}>{}</{close}>", Escaped(words)),
            Self::Name { name, about, series } => {
                write!(f, "<{open}>")?;
                if let Some(series) = series {
                    write!(f, "<i class=\"key {}\"></i>", series_class(*series))?;
                }
                let name = Escaped(name);
                if about.is_empty() {
                    write!(f, "{name}")?;
                } else {
                    write!(f, "<span class=\"def\" tabindex=\"0\">{name}<small>")?;
                    for (what, text) in about {
                        write!(f, "<b>{what}</b> {}<br>", Escaped(text))?;
                    }
                    f.write_str("</small></span>")?;
                }
                write!(f, "</{close}>")
            }
            Self::Figure { shown, unit, value, exact } => {
                write!(
                    f,
                    "<td class=\"n\" data-v=\"{value}\" title=\"{}\">{}",
                    Escaped(exact.trim_end()),
                    Escaped(shown)
                )?;
                if let Some(unit) = unit {
                    write!(f, "<span class=\"u\">{}</span>", Escaped(unit))?;
                }
                f.write_str("</td>")
            }
            Self::Absent(reason) => {
                write!(f, "<td class=\"n none\" title=\"{}\">&ndash;</td>", Escaped(reason))
            }
        }
    }
}

/// The class that colours a series; series after the eighth are striped.
pub(super) fn series_class(series: usize) -> String {
    format!("s{}", series % crate::chart::MOST_SERIES)
}

/// A bar of parts of a whole, each with its series, a sentence about it, and its share from 0 to 1.
pub(super) fn bar(label: &str, parts: &[(usize, String, f64)]) -> String {
    let mut out = format!("<div class=\"bar\" role=\"img\" aria-label=\"{}\">", Escaped(label));
    for (series, sentence, share) in parts {
        let (class, width) = (series_class(*series), 100.0 * share);
        out +=
            &format!("<i class=\"{class}\" style=\"width:{width:.3}%\" title=\"{}\"></i>", Escaped(sentence));
    }
    out + "</div>\n"
}

/// A section with its heading, where it has something to say.
pub(super) fn section(id: &str, title: &str, body: &str) -> String {
    if body.is_empty() {
        return String::new();
    }
    format!("<section id=\"{id}\"><h2>{}</h2>\n{body}</section>\n", Escaped(title))
}

/// A list of sentences under a smaller heading, where there is one.
pub(super) fn sentences<'a>(title: &str, sentences: impl IntoIterator<Item = &'a str>) -> String {
    let items = items(sentences);
    if items.is_empty() { items } else { format!("<h3>{}</h3>\n<ul>{items}</ul>\n", Escaped(title)) }
}

/// As [`sentences`], behind its title until a reader asks for them.
pub(super) fn folded<'a>(title: &str, sentences: impl IntoIterator<Item = &'a str>) -> String {
    let items = items(sentences);
    if items.is_empty() {
        return items;
    }
    format!("<details><summary>{}</summary>\n<ul>{items}</ul></details>\n", Escaped(title))
}

fn items<'a>(sentences: impl IntoIterator<Item = &'a str>) -> String {
    sentences.into_iter().map(|text| format!("<li>{}</li>\n", Escaped(text))).collect()
}

/// Terms and what is said of each.
pub(super) fn terms<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let row = |(term, text): (&str, String)| {
        format!("<div><dt>{}</dt><dd>{}</dd></div>\n", Escaped(term), Escaped(&text))
    };
    format!("<dl class=\"terms\">{}</dl>\n", rows.into_iter().map(row).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_leave_its_place() {
        let text = "</script><img src=x onerror='a'> & \"b\"";
        let shown = Escaped(text).to_string();
        assert_eq!(shown, "&lt;/script&gt;&lt;img src=x onerror=&#39;a&#39;&gt; &amp; &quot;b&quot;");
    }

    #[test]
    fn a_figure_is_sorted_by_its_value_and_keeps_every_digit() {
        let table = Table {
            label: "t".into(),
            columns: vec![Column::words("what"), Column::figures("size")],
            groups: vec![Group {
                title: None,
                rows: vec![vec![Cell::Words("a".into()), Cell::bytes(1_234_567)]],
            }],
            filter: false,
        };
        let text = table.to_string();
        assert!(
            text.contains("data-v=\"1234567\" title=\"1234567 B\">1.177<span class=\"u\">MiB</span>"),
            "{text}"
        );
    }
}
