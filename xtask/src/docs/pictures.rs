//! Pictures of pages, which are figures of the report that their commands write.

/// A picture of a page: its file, and which figure of the report it is.
#[derive(Debug, PartialEq)]
pub(super) struct Picture<'a> {
    pub(super) file: &'a str,
    pub(super) figure: &'a str,
}

/// The pictures of a page: those whose title, as in `![a river](nile.svg "level")`, names a figure.
pub(super) fn pictures(page: &str) -> Vec<Picture<'_>> {
    let links = page.split("](").skip(1);
    links
        .filter_map(|link| {
            let (file, rest) = link.split_once(" \"")?;
            let (figure, _) = rest.split_once("\")")?;
            (!file.contains([')', '\n'])).then_some(Picture { file, figure })
        })
        .collect()
}

/// The figure of a report that has this heading.
pub(super) fn figure<'a>(report: &'a str, heading: &str) -> Option<&'a str> {
    let figures = report.split("<svg").skip(1).filter_map(|rest| rest.split_once("</svg>"));
    let is_it = |svg: &str| {
        let first = svg.split_once("<text").and_then(|(_, text)| text.split_once('>'));
        first.and_then(|(_, text)| text.split('<').next()).is_some_and(|text| text.trim() == heading)
    };
    let (svg, _) = figures.into_iter().find(|(svg, _)| is_it(svg))?;
    // From its first letter to its last, as it stands in the report.
    let start = svg.as_ptr() as usize - report.as_ptr() as usize - "<svg".len();
    report.get(start..start + "<svg".len() + svg.len() + "</svg>".len())
}

#[cfg(test)]
mod tests {
    use super::{Picture, figure, pictures};

    #[test]
    fn a_picture_is_a_figure_of_the_report() {
        let page = "[no](other.md) \"no\")\n![a river](nile.svg \"flow (measured)\")\n";
        assert_eq!(pictures(page), [Picture { file: "nile.svg", figure: "flow (measured)" }]);
        let report = "<svg a=\"1\"><text x=\"2\">\nflow\n</text></svg><svg b=\"1\"><text>\nlevel\n</text><text>t</text></svg>";
        assert_eq!(figure(report, "level"), Some("<svg b=\"1\"><text>\nlevel\n</text><text>t</text></svg>"));
        assert_eq!(figure(report, "t"), None);
    }
}
