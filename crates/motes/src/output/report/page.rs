//! A plain page that one can read on a screen and print.

use std::fmt::Write;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#282828;max-width:60rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}table{border-collapse:collapse;margin:.5rem 0}\
td,th{padding:.15rem 1.2rem .15rem 0;text-align:left;border-bottom:1px solid #ddd;font-variant-numeric:tabular-nums}\
figure{margin:.6rem 0}svg{max-width:100%;height:auto}code{background:#f4f4f4;padding:.1rem .3rem;overflow-wrap:anywhere}\
.warning{border-left:4px solid #c03020;padding:.3rem .8rem;background:#fdf3f1;margin:.4rem 0}.fine{color:#2a7a3f}p{margin:.4rem 0}";

/// A page in the making.
pub(super) struct Page {
    text: String,
}

/// Text as HTML shows it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl Page {
    pub(super) fn new(title: &str) -> Self {
        let title = escaped(title);
        Page {
            text: format!(
                "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
                 <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
            ),
        }
    }

    pub(super) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.text, "<h2>{}</h2>", escaped(text));
    }

    pub(super) fn note(&mut self, text: &str) {
        let _ = writeln!(self.text, "<p>{}</p>", escaped(text));
    }

    pub(super) fn command(&mut self, text: &str) {
        let _ = writeln!(self.text, "<p>Made by <code>{}</code></p>", escaped(text));
    }

    pub(super) fn warnings(&mut self, warnings: &[String]) {
        if warnings.is_empty() {
            let _ = writeln!(self.text, "<p class=\"fine\">No warnings.</p>");
        }
        for warning in warnings {
            let _ = writeln!(self.text, "<p class=\"warning\">{}</p>", escaped(warning));
        }
    }

    /// A figure as SVG, with a line below it.
    pub(super) fn figure(&mut self, svg: &str, caption: &str) {
        let below = match caption.is_empty() {
            true => String::new(),
            false => format!("<figcaption>{}</figcaption>", escaped(caption)),
        };
        let _ = writeln!(self.text, "<figure>{svg}{below}</figure>");
    }

    /// A table; a header without names is left out.
    pub(super) fn table(&mut self, header: &[&str], rows: impl Iterator<Item = Vec<String>>) {
        self.text += "<table>\n";
        if header.iter().any(|name| !name.is_empty()) {
            let cells: String = header.iter().map(|name| format!("<th>{}</th>", escaped(name))).collect();
            let _ = writeln!(self.text, "<tr>{cells}</tr>");
        }
        for row in rows {
            let cells: String = row.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
            let _ = writeln!(self.text, "<tr>{cells}</tr>");
        }
        self.text += "</table>\n";
    }

    /// Names and values.
    pub(super) fn pairs(&mut self, pairs: &[(String, String)]) {
        self.table(&["", ""], pairs.iter().map(|(name, value)| vec![name.clone(), value.clone()]));
    }

    pub(super) fn finish(mut self) -> String {
        self.text += "</body>\n</html>\n";
        self.text
    }
}
