//! What pages showed or ran that they should not.

use powergs_chart::{Chart, Format};
use powergs_report::document::{Block, Document, Shown};

#[test]
fn the_title_of_a_chart_is_text_in_markdown() {
    let mut page = Document::new();
    page.charts(&[Chart::new("front", "a](b) ![x](y) <i>", "")]);
    let text = page.markdown(Format::Png);
    assert!(text.starts_with("![a\\](b) !\\[x\\](y) \\<i>](front.png)"), "{text}");
}

#[test]
fn what_is_shown_as_it_is_ends_where_it_ends() {
    let mut page = Document::new();
    page.on(Shown::Page, Block::Verbatim("run '\n```\n# not a heading'".into()));
    let text = page.markdown(Format::Png);
    assert!(text.starts_with("````\nrun ") && text.trim_end().ends_with("\n````"), "{text}");
}

/// A browser runs the script of the page and nothing else, and opens no address.
#[test]
fn a_page_has_a_policy() {
    let html = Document::new().html().expect("no chart");
    let (_, policy) = html.split_once("Content-Security-Policy\" content=\"").expect("a policy");
    let (policy, rest) = policy.split_once('"').expect("an end");
    assert!(policy.starts_with("default-src 'none'; script-src 'sha256-"), "{policy}");
    assert!(!policy.contains("unsafe-eval") && !policy.contains("script-src 'unsafe"), "{policy}");
    assert!(rest.contains("<style>"), "it comes before what it rules");
    let (_, script) = html.rsplit_once("<script>").expect("a script");
    let (script, _) = script.split_once("</script>").expect("an end");
    let hash = <sha2::Sha256 as sha2::Digest>::digest(script.as_bytes());
    let hash = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, hash);
    assert!(policy.contains(&format!("'sha256-{hash}'")), "{policy}");
}
