//! `report.html` and `appendix.html`: each a self-contained page. It needs no other file and no network.

use std::fmt::Write;

use pulldown_cmark::html::push_html;
use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd};

use crate::study::present::chart::{Chart, escaped, page_style};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// The content security policy: the page may load nothing, even if it is altered later.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// The page of a report in Markdown. Each image is replaced by its chart.
pub(crate) fn report_html(markdown: &str, charts: &[Chart]) -> String {
    let events: Vec<Event> = Parser::new_ext(markdown, Options::ENABLE_TABLES).collect();
    let mut headings: Vec<Heading> = Vec::new();
    let mut page = Vec::new();
    let mut rest = events.into_iter();
    while let Some(event) = rest.next() {
        match event {
            Event::Start(Tag::Heading { level, .. }) => {
                let inner: Vec<_> =
                    rest.by_ref().take_while(|event| !matches!(event, Event::End(TagEnd::Heading(_)))).collect();
                let heading = Heading::new(level, &inner, &headings);
                page.push(raw(format!("<{level} id=\"{}\">", heading.id)));
                page.extend(inner);
                page.push(raw(format!("</{level}>\n")));
                headings.push(heading);
            }
            Event::Start(Tag::Image { dest_url, .. }) => {
                let inner: Vec<_> =
                    rest.by_ref().take_while(|event| !matches!(event, Event::End(TagEnd::Image))).collect();
                page.push(Event::InlineHtml(figure(&dest_url, &text(&inner), charts).into()));
            }
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                // Pages link to pages.
                let dest_url = dest_url.replace(".md", ".html").into();
                page.push(Event::Start(Tag::Link { link_type, dest_url, title, id }));
            }
            Event::Start(Tag::Table(_)) => page.extend([raw("<div class=\"table\" tabindex=\"0\">"), event]),
            Event::End(TagEnd::Table) => page.extend([event, raw("</div>\n")]),
            event => page.push(event),
        }
    }
    let mut body = String::new();
    push_html(&mut body, page.into_iter());
    // Most cells are numbers: a class is shorter than a style on each of them.
    let body = body.replace(" style=\"text-align: right\"", " class=\"n\"");
    let title = headings.iter().find(|heading| heading.level == HeadingLevel::H1).map_or("", |heading| &heading.text);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{colors}{STYLE}</style>\n</head>\n<body>\n{contents}<main>\n{body}</main>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        title = escaped(title),
        colors = page_style(),
        contents = contents(&headings),
    )
}

/// A heading that the contents link to.
struct Heading {
    level: HeadingLevel,
    text: String,
    /// ID, unique in the page.
    id: String,
}

impl Heading {
    fn new(level: HeadingLevel, inner: &[Event], others: &[Self]) -> Self {
        let text = text(inner);
        let slug = anchor(&text);
        let is_free = |id: &String| others.iter().all(|other| other.id != *id);
        let mut ids = [slug.clone()].into_iter().chain((2..).map(|number| format!("{slug}-{number}")));
        let id = ids.find(is_free).expect("the numbers are endless");
        Self { level, text, id }
    }
}

/// The name of a heading in links, as code hosts form it: letters, digits and hyphens.
pub(super) fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|&letter| letter.is_alphanumeric() || letter == ' ' || letter == '-');
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// The table of contents: sections and their subsections.
fn contents(headings: &[Heading]) -> String {
    let mut html = "<nav><details open><summary>Contents</summary>\n<ol>\n".to_owned();
    let listed: Vec<_> = headings.iter().filter(|heading| heading.level != HeadingLevel::H1).collect();
    // A subsection before any section is listed on its own.
    for section in listed.chunk_by(|_, next| next.level != HeadingLevel::H2) {
        let mut lines =
            section.iter().map(|Heading { id, text, .. }| format!("<li><a href=\"#{id}\">{}</a>", escaped(text)));
        html += &lines.next().unwrap_or_default();
        let parts: String = lines.map(|line| line + "\n").collect();
        if !parts.is_empty() {
            write!(html, "\n<ol>\n{parts}</ol>").expect("writing to a string cannot fail");
        }
        html.push('\n');
    }
    html + "</ol>\n</details></nav>\n"
}

/// A chart within the page, or its title if there is no such chart.
fn figure(file: &str, alt: &str, charts: &[Chart]) -> String {
    let Some(svg) = charts.iter().find(|chart| chart.file == file).map(|chart| &chart.svg) else {
        return escaped(alt);
    };
    format!(
        "<span class=\"chart\">{}</span>",
        svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escaped(alt)), 1)
    )
}

/// The text of events, without markup.
fn text(events: &[Event]) -> String {
    let texts = events.iter().filter_map(|event| match event {
        Event::Text(text) | Event::Code(text) | Event::InlineHtml(text) => Some(text.as_ref()),
        Event::SoftBreak => Some(" "),
        _ => None,
    });
    texts.collect()
}

fn raw<'a>(html: impl Into<CowStr<'a>>) -> Event<'a> {
    Event::Html(html.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::present::chart::charts;
    use crate::study::present::report::{answer_markdown, appendix_markdown};
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

    fn page(record: &crate::study::record::Record) -> String {
        report_html(&appendix_markdown(record), &charts(record))
    }

    #[test]
    fn every_chart_is_in_one_of_the_pages() {
        let record = record_of(&all_ids());
        let charts = charts(&record);
        let appendix = appendix_markdown(&record);
        let pages = [answer_markdown(&record, &appendix), appendix].map(|text| report_html(&text, &charts));
        let all = pages.concat();
        assert_eq!(all.matches("<svg role=\"img\" aria-label=\"").count(), charts.len());
        for chart in &charts {
            let (_, drawn) = chart.svg.split_once('>').unwrap();
            assert_eq!(all.matches(drawn).count(), 1, "{}", chart.file);
        }
        assert!(!all.contains("<img") && all.len() < 4_000_000, "{}", all.len());
    }

    #[test]
    fn a_page_loads_nothing() {
        let page = page(&record_of(&all_ids()));
        // Browsers do not load namespaces.
        let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for loading in [" src=", "<link", "@import", "url(", "fetch(", "XMLHttp", " href=\"http"] {
            assert!(!page.contains(loading), "{loading}");
        }
        assert!(page.contains("content=\"default-src 'none';"));
    }

    #[test]
    fn headings_have_unique_ids_and_every_link_has_a_target() {
        let page = page(&record_of(&all_ids()));
        let ids: Vec<_> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(ids.len() > 30);
        for (i, id) in ids.iter().enumerate() {
            assert!(!ids[..i].contains(id) && !id.is_empty(), "{id}");
        }
        for target in page.split("href=\"#").skip(1).filter_map(|rest| rest.split('"').next()) {
            assert!(ids.contains(&target), "{target}");
        }
        // All headings except the title are in the contents.
        assert_eq!(page.matches("<a href=\"#").count(), ids.len() - 1);
        let twice = report_html("# T\n\n### Part\n\n## Same `a`\n\n## Same a\n", &[]);
        assert!(twice.contains("<h2 id=\"same-a\">") && twice.contains("<h2 id=\"same-a-2\">"), "{twice}");
    }

    #[test]
    fn text_is_escaped() {
        let page = report_html(
            "# A & B\n\n| a | b |\n| --- | --: |\n| `x < y & <b>` | 1 |\n\n![\"<i>\"](x.svg)\n",
            &[Chart { file: "x.svg".into(), svg: "<svg width=\"1\"></svg>".into() }],
        );
        assert!(page.contains("<title>A &amp; B</title>"));
        assert!(page.contains("<code>x &lt; y &amp; &lt;b&gt;</code>"), "{page}");
        assert!(page.contains("<svg role=\"img\" aria-label=\"&quot;&lt;i&gt;&quot;\" width=\"1\">"), "{page}");
        assert!(page.contains("<td class=\"n\">1</td>"));
    }

    #[test]
    fn degenerate_records_have_a_page() {
        for record in degenerate_records() {
            assert!(page(&record).ends_with("</html>\n"));
        }
    }
}
