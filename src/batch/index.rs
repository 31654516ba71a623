//! A page of all parts, worst first, with a picture of each that leads to its report.

use super::row::Row;
use crate::error::escaped;
use crate::notice::number_of;
use crate::report::markup::{Markup, markup};

/// The words for one part and for several.
pub const PARTS: [&str; 2] = ["part", "parts"];

/// The page; pictures and reports stand beside it and are named by their places below it.
pub fn page(rows: &[Row]) -> String {
    let parts = number_of(rows.len() as u64, PARTS);
    let mut sorted: Vec<&Row> = rows.iter().collect();
    sorted.sort_by(|a, b| b.badness().cmp(&a.badness()).then_with(|| a.part.cmp(&b.part)));
    let head = markup!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src 'self' data: file:; \
         style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
        format!("amcheck: {parts}"),
        Markup::raw(include_str!("index.css"))
    );
    let counts = [
        ("nothing fails", [0].as_slice()),
        ("undecided", &[3]),
        ("fail", &[1]),
        ("unreadable or no solid", &[4]),
        ("too large", &[5]),
        ("not written", &[6]),
        ("broke down", &[70]),
    ];
    let counted: Vec<String> = counts
        .iter()
        .map(|(words, codes)| (rows.iter().filter(|r| codes.contains(&r.code)).count(), words))
        .filter(|(n, _)| *n > 0)
        .map(|(n, words)| format!("{n} {words}"))
        .collect();
    let title = markup!("<h1>{}</h1>\n<p>{}</p>\n", parts, counted.join(" · "));
    let columns = Markup::raw(
        "<table>\n<thead><tr><th></th><th>Part</th><th>Result</th><th>Code</th><th>Size, mm</th><th>Seconds</th><th>MiB</th></tr></thead>\n<tbody>\n",
    );
    let lines = sorted.into_iter().map(line);
    Markup::all(
        [head, title, columns].into_iter().chain(lines).chain([Markup::raw("</tbody>\n</table>\n</body>\n</html>\n")]),
    )
    .into_string()
}

fn line(row: &Row) -> Markup {
    let state = match (row.verdict, row.code) {
        (Some(v), _) => format!("{v:?}").to_lowercase(),
        (None, 70) => "error".into(),
        (None, _) => "refused".into(),
    };
    let place = row.folder.as_deref().filter(|_| row.verdict.is_some()).map(address);
    let (picture, name) = match &place {
        Some(place) => (
            markup!(
                "<a href=\"{}/report.html\"><img src=\"{}/thumbnail.png\" width=\"160\" height=\"100\" loading=\"lazy\" alt=\"\"></a>",
                *place,
                *place
            ),
            markup!("<a href=\"{}/report.html\">{}</a>", *place, escaped(&row.part)),
        ),
        None => (Markup::default(), markup!("{}", escaped(&row.part))),
    };
    let size = row.size_mm.map_or(String::new(), |s| s.map(|x| format!("{x:.1}")).join(" × "));
    markup!(
        "<tr class=\"{}\"><td class=\"picture\">{}</td><td class=\"part\">{}</td><td><b>{}</b> {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        state,
        picture,
        name,
        state,
        row.line,
        row.code.to_string(),
        size,
        format!("{:.1}", row.seconds),
        row.peak_mib.map_or(String::new(), |m| format!("{m:.0}"))
    )
}

/// A relative place as an address: everything but letters, digits and a few signs as percent and two digits.
fn address(place: &str) -> String {
    let plain = |b: &u8| b.is_ascii_alphanumeric() || b"-_./".contains(b);
    place.bytes().map(|b| if plain(&b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::report::Verdict;

    #[test]
    fn the_worst_part_stands_first() {
        let refused = |part: &str| Row::refused(part, &Error::Interrupted);
        let judged = |part: &str, verdict: Verdict, findings: [u64; 3]| Row {
            code: 0,
            verdict: Some(verdict),
            findings,
            ..refused(part)
        };
        let rows = [
            judged("a", Verdict::Pass, [0, 0, 0]),
            judged("b", Verdict::Warn, [0, 0, 2]),
            judged("c", Verdict::Warn, [0, 0, 3]),
            judged("d", Verdict::Undecided, [0, 1, 9]),
            judged("e", Verdict::Fail, [1, 0, 0]),
            judged("f", Verdict::Fail, [2, 0, 0]),
            judged("g", Verdict::Fail, [2, 0, 0]),
            refused("h"),
        ];
        let page = page(&rows);
        let name = |cell: &str| cell.split("</td>").next().map(str::to_string);
        let told: Vec<String> = page.split("<td class=\"part\">").skip(1).filter_map(name).collect();
        assert_eq!(told, ["h", "f", "g", "e", "d", "c", "b", "a"]);
    }
}
