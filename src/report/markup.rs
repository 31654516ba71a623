//! HTML, SVG and XML text that cannot be broken out of: what is filled in is escaped unless it is markup itself.

/// Finished markup.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Markup(String);

/// Something that can be filled into a template.
pub trait Piece {
    /// Appends itself, escaped for element text and for quoted attributes.
    fn write(&self, out: &mut String);
}

impl Markup {
    /// Markup from a text of the program's own.
    pub fn raw(text: &'static str) -> Self {
        Markup(text.into())
    }

    /// Markup that another writer of this crate has made and escaped: a chart, an encoded picture.
    pub fn made(text: String) -> Self {
        Markup(text)
    }

    /// A template with each `{}` replaced by the next piece.
    ///
    /// Too few pieces leave the last places empty; too many are dropped. `{{` is not special.
    pub fn filled(template: &'static str, pieces: &[&dyn Piece]) -> Self {
        let mut out = String::with_capacity(template.len() + 64);
        let mut pieces = pieces.iter();
        let mut parts = template.split("{}");
        out.push_str(parts.next().unwrap_or(""));
        for part in parts {
            if let Some(piece) = pieces.next() {
                piece.write(&mut out);
            }
            out.push_str(part);
        }
        Markup(out)
    }

    /// The pieces one after the other.
    pub fn all(pieces: impl IntoIterator<Item = Markup>) -> Self {
        Markup(pieces.into_iter().map(|m| m.0).collect())
    }

    /// The text.
    pub fn into_string(self) -> String {
        self.0
    }

    /// Bytes of the text.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// A text escaped for elements and quoted attributes of HTML and XML; controls that XML forbids become `\u{fffd}`.
///
/// ```
/// assert_eq!(amcheck::report::markup::escaped("<a b='\"'>&"), "&lt;a b=&#39;&quot;&#39;&gt;&amp;");
/// ```
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

impl Piece for Markup {
    fn write(&self, out: &mut String) {
        out.push_str(&self.0);
    }
}

impl Piece for str {
    fn write(&self, out: &mut String) {
        out.push_str(&escaped(self));
    }
}

impl Piece for &str {
    fn write(&self, out: &mut String) {
        out.push_str(&escaped(self));
    }
}

impl Piece for String {
    fn write(&self, out: &mut String) {
        out.push_str(&escaped(self));
    }
}

impl Piece for usize {
    fn write(&self, out: &mut String) {
        out.push_str(&self.to_string());
    }
}

/// A template filled with pieces: `markup!("<b>{}</b>", name)`.
macro_rules! markup {
    ($template:literal $(, $piece:expr)* $(,)?) => {
        $crate::report::markup::Markup::filled($template, &[$(&$piece as &dyn $crate::report::markup::Piece),*])
    };
}
pub(crate) use markup;

#[cfg(test)]
mod tests {
    #[test]
    fn only_markup_passes_unescaped() {
        let name = "</script><img src=x>";
        let inner = markup!("<b title=\"{}\">{}</b>", "a\"b", name);
        assert_eq!(
            markup!("<p>{}{}</p>", inner, 3usize).into_string(),
            "<p><b title=\"a&quot;b\">&lt;/script&gt;&lt;img src=x&gt;</b>3</p>"
        );
    }
}
