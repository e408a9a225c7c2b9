//! A Markdown page: its blocks of code, its spans of code, its headings and links.

/// What stands on a page, in the order of the page.
pub(crate) struct Page {
    /// Relative to the repository, such as `docs/budgets.md`.
    pub(crate) name: String,
    pub(crate) items: Vec<Item>,
}

pub(crate) struct Item {
    /// Where it begins, from 1.
    pub(crate) line: usize,
    pub(crate) kind: Kind,
}

pub(crate) enum Kind {
    /// Between fences.
    Block {
        language: String,
        text: String,
    },
    /// Between backticks.
    Code {
        text: String,
        /// What follows it in the paragraph.
        after: String,
    },
    Heading(String),
    /// Where a link leads.
    Link(String),
}

impl Page {
    pub(crate) fn read(name: &str) -> Self {
        let path = crate::root().join(name);
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        Self::of(name, &text)
    }

    pub(crate) fn of(name: &str, text: &str) -> Self {
        Self { name: name.to_owned(), items: items(name, text) }
    }

    /// The first block that is a file of that name, as its first line says.
    pub(crate) fn file(&self, name: &str) -> Option<&str> {
        let first = format!("# {name}\n");
        self.items.iter().find_map(|item| match &item.kind {
            Kind::Block { text, .. } if text.starts_with(&first) => Some(text.as_str()),
            _ => None,
        })
    }

    /// `page:line`, for messages.
    pub(crate) fn place(&self, item: &Item) -> String {
        format!("{}:{}", self.name, item.line)
    }
}

fn items(name: &str, text: &str) -> Vec<Item> {
    let mut items = Vec::new();
    let mut paragraph = (0, String::new());
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        let line_number = index + 1;
        if let Some(language) = line.trim_start().strip_prefix("```") {
            end_paragraph(&mut paragraph, &mut items);
            let mut block = String::new();
            loop {
                let (_, line) =
                    lines.next().unwrap_or_else(|| panic!("{name}:{line_number}: the fence is not closed"));
                if line.trim() == "```" {
                    break;
                }
                block += line;
                block.push('\n');
            }
            let language = language.trim().to_owned();
            items.push(Item { line: line_number, kind: Kind::Block { language, text: block } });
        } else if line.starts_with('#') {
            end_paragraph(&mut paragraph, &mut items);
            let heading = line.trim_start_matches('#').trim().to_owned();
            items.push(Item { line: line_number, kind: Kind::Heading(heading) });
        } else if line.trim().is_empty() || line.starts_with('|') {
            end_paragraph(&mut paragraph, &mut items);
            paragraph = (line_number, line.to_owned());
        } else {
            if paragraph.1.trim().is_empty() {
                paragraph.0 = line_number;
            }
            paragraph.1.push(' ');
            paragraph.1 += line.trim();
        }
    }
    end_paragraph(&mut paragraph, &mut items);
    items
}

/// Takes spans of code and links out of a paragraph or a row of a table.
fn end_paragraph(paragraph: &mut (usize, String), items: &mut Vec<Item>) {
    let (line, text) = std::mem::take(paragraph);
    let mut prose = String::new();
    let mut rest = text.as_str();
    while let Some(start) = rest.find('`') {
        prose += &rest[..start];
        let ticks = rest[start..].len() - rest[start..].trim_start_matches('`').len();
        let fence = &rest[start..start + ticks];
        let inside = &rest[start + ticks..];
        let Some(end) = inside.find(fence) else {
            break;
        };
        let after = inside[end + ticks..].to_owned();
        let kind = Kind::Code { text: inside[..end].trim().to_owned(), after };
        items.push(Item { line, kind });
        prose.push('_');
        rest = &inside[end + ticks..];
    }
    prose += rest;
    for part in prose.split("](").skip(1) {
        if let Some((target, _)) = part.split_once(')') {
            items.push(Item { line, kind: Kind::Link(target.to_owned()) });
        }
    }
}
