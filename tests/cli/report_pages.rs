//! `report`: a whole page in one file, whatever the names in the pack are.

use crate::bench::{Bench, SPHERE, TRIANGLE, TUBE, TWO_MATERIALS};
use crowd_pack::Pack;

/// Elements that HTML lets stand without an end.
const VOID: [&str; 6] = ["meta", "img", "br", "col", "input", "path"];
const HOSTILE: &str = "</title><script>alert(1)</script>\"'&\u{202e}";

/// A start tag: its name and its attributes.
struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
}

impl Tag {
    fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value.as_str())
    }
}

/// Start tags of a page, in order. Panics where an element does not end, ends twice, or an attribute has no quotes.
fn parse(page: &str) -> Vec<Tag> {
    let mut rest = page.strip_prefix("<!DOCTYPE html>").expect("a doctype");
    let (mut open, mut tags): (Vec<String>, Vec<Tag>) = (Vec::new(), Vec::new());
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "a loose `>` near {:?}", &rest[..start.min(80)]);
        rest = &rest[start + 1..];
        let (inside, after) = split_tag(rest);
        rest = after;
        if let Some(name) = inside.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "an end that fits no start");
            continue;
        }
        let tag = parse_tag(inside.trim_end_matches('/'));
        let ends = inside.ends_with('/');
        assert!(ends == VOID.contains(&tag.name.as_str()), "<{inside}>");
        if tag.name == "style" || tag.name == "script" {
            let end = rest.find(&format!("</{}>", tag.name)).expect("raw text ends");
            rest = &rest[end..];
        }
        if !ends {
            open.push(tag.name.clone());
        }
        tags.push(tag);
    }
    assert!(open.is_empty(), "never ended: {open:?}");
    tags
}

/// What is inside a tag, and what follows it; a `>` between quotes does not end it.
fn split_tag(text: &str) -> (&str, &str) {
    let mut quoted = false;
    for (place, letter) in text.char_indices() {
        match letter {
            '"' => quoted = !quoted,
            '>' if !quoted => return (&text[..place], &text[place + 1..]),
            '<' => panic!("a `<` within a tag: {:?}", &text[..place.min(80)]),
            _ => {}
        }
    }
    panic!("a tag does not end");
}

fn parse_tag(inside: &str) -> Tag {
    let (name, mut rest) = inside.split_once(' ').unwrap_or((inside, ""));
    assert!(name.chars().all(|c| c.is_ascii_alphanumeric()), "<{name}>");
    let mut attributes: Vec<(String, String)> = Vec::new();
    while !rest.trim().is_empty() {
        let (key, after) = rest.trim_start().split_once("=\"").expect("attributes have values in double quotes");
        let (value, after) = after.split_once('"').expect("a value ends");
        assert!(key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-'), "{key}");
        assert!(attributes.iter().all(|(known, _)| known != key), "{key} twice");
        attributes.push((key.to_owned(), value.to_owned()));
        rest = after;
    }
    Tag { name: name.to_owned(), attributes }
}

fn decode_base64(text: &str) -> Vec<u8> {
    let value = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => panic!("not base64: {letter}"),
    };
    let (mut bits, mut count, mut out) = (0_u32, 0, Vec::new());
    for letter in text.trim_end_matches('=').bytes() {
        bits = (bits << 6) | u32::from(value(letter));
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    out
}

/// The page as its tags, after everything that must hold for any page was looked at.
fn check(page: &str) -> Vec<Tag> {
    let tags = parse(page);
    let mut ids: Vec<&str> = tags.iter().filter_map(|tag| tag.attribute("id")).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "an id twice");
    for link in tags.iter().filter(|tag| tag.name == "a") {
        let target = link.attribute("href").and_then(|href| href.strip_prefix('#')).expect("links stay in the page");
        assert!(ids.contains(&target), "#{target}");
    }
    for image in tags.iter().filter(|tag| tag.name == "img") {
        assert!(image.attribute("alt").is_some());
        if let Some(source) = image.attribute("src") {
            let bytes = decode_base64(source.strip_prefix("data:image/jpeg;base64,").expect("pictures are inside"));
            let picture = image::load_from_memory(&bytes).expect("a JPEG");
            let side = |name: &str| image.attribute(name).and_then(|side| side.parse::<u32>().ok());
            assert_eq!((side("width"), side("height")), (Some(picture.width()), Some(picture.height())));
        }
    }
    for away in ["http:", "https:", "src=\"/", "url(", "@import", "<link"] {
        assert!(!page.contains(away), "the page must not ask for anything: {away}");
    }
    assert_eq!(tags.iter().filter(|tag| tag.name == "script").count(), 1);
    tags
}

fn bake(bench: &Bench, fixtures: &[&str]) {
    let inputs: Vec<String> = fixtures.iter().map(|fixture| format!("@{fixture}")).collect();
    let mut words = vec!["-q", "bake", "-o", "@out.crowdpack"];
    words.extend(inputs.iter().map(String::as_str));
    bench.run(&words).expect(0);
}

fn page(bench: &Bench) -> String {
    String::from_utf8(bench.read("report.html")).expect("a page is UTF-8")
}

#[test]
fn the_checker_finds_what_is_wrong() {
    let wrong = |page: &str| std::panic::catch_unwind(|| check(&format!("<!DOCTYPE html>{page}"))).is_err();
    assert!(!wrong("<p class=\"a\">x<br/></p><script>a < b</script>"));
    for page in [
        "<p>x",
        "<p></b>",
        "<p a=b></p><script></script>",
        "<p>a > b</p><script></script>",
        "<img src=\"x.png\" alt=\"\"/><script></script>",
        "<a href=\"#nowhere\"></a><script></script>",
        "<script></script><script></script>",
    ] {
        assert!(wrong(page), "{page}");
    }
}

#[test]
fn a_page_holds_everything_that_it_shows() {
    let fixtures = [TUBE, SPHERE, TWO_MATERIALS, TRIANGLE];
    let bench = Bench::with(&fixtures);
    bake(&bench, &fixtures);
    bench.run(&["report", "@out.crowdpack", "-o", "@report.html"]).expect(0).says(&["report.html: 4 characters"]);
    let page = page(&bench);
    let tags = check(&page);
    let sections = tags.iter().filter(|tag| tag.attribute("class") == Some("character")).count();
    assert_eq!(sections, 4);
    for words in ["At rest", "At its worst: bend", "Wireframe", "Vertex classes", "Seams over the texture", "RMS"] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(
        tags.iter().filter(|tag| tag.attribute("class") == Some("chart")).count(),
        3,
        "one triangle has no curve"
    );
    assert!(page.contains("prefers-color-scheme: dark"));
}

#[test]
fn discrete_levels_stand_beside_those_they_were_made_from() {
    let bench = Bench::with(&[TUBE]);
    let words = ["-q", "bake", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--lod-ratio", "25%,7%,4%", "--refit"];
    bench.run(&words).expect(0);
    bench.run(&["report", "@out.crowdpack", "-o", "@report.html"]).expect(0);
    let page = page(&bench);
    let tags = check(&page);
    // Full, 50, 25, 10, 5 and 2 % (the coarsest), and three refitted ones, in four looks and two poses.
    let drawn = tags.iter().filter(|tag| tag.attribute("data-level").is_some()).count();
    assert_eq!(drawn, 9 * 4 * 2);
    for words in [
        "<b>lod1, refitted</b>",
        "<b>lod3, refitted</b>",
        "asked: 7% of the triangles",
        "RMS of refitted levels",
        "Refitted<br/>(RMS)",
        "class=\"scroll wide\"",
        "Poked<br/>through",
    ] {
        assert!(page.contains(words), "{words}");
    }
    bench.run(&["-q", "bake", &format!("@{TUBE}"), "-o", "@plain.crowdpack", "--lod-ratio", "25%"]).expect(0);
    bench.run(&["report", "@plain.crowdpack", "-o", "@report.html"]).expect(0);
    let page = String::from_utf8(bench.read("report.html")).unwrap();
    assert!(!page.contains("Refitted<br/>") && !page.contains("scroll wide"), "nothing to tell of");
    assert!(page.contains("25\u{a0}%, lod1</b>") && !page.contains("refitted</b>"), "one column for one level");
}

#[test]
fn names_stay_text_whatever_they_are() {
    let bench = Bench::with(&[TUBE]);
    bake(&bench, &[TUBE]);
    let mut contents = Pack::open(&bench.path("out.crowdpack")).unwrap().contents().clone();
    let character = &mut contents.manifest.characters[0];
    character.name = HOSTILE.to_owned();
    character.source = HOSTILE.to_owned();
    character.clips[0].name = HOSTILE.to_owned();
    character.materials.iter_mut().for_each(|name| *name = HOSTILE.to_owned());
    character.parts.iter_mut().for_each(|part| part.name = HOSTILE.to_owned());
    character.nodes.iter_mut().for_each(|node| node.name = HOSTILE.to_owned());
    character.warnings.push(HOSTILE.to_owned());
    contents.manifest.generator = HOSTILE.to_owned();
    contents.write(&bench.path("odd <b>&.crowdpack")).unwrap();
    bench.run(&["report", "@odd <b>&.crowdpack", "-o", "@report.html"]).expect(0);
    let page = page(&bench);
    check(&page);
    assert!(!page.contains("<script>alert") && !page.contains('\u{202e}') && !page.contains("odd <b>"));
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    let text = bench.run(&["explain", "@odd <b>&.crowdpack", "--ratio", "10%"]).expect(0).out;
    assert!(!text.contains('\u{202e}'));
}

#[test]
fn the_same_pack_gives_the_same_page_on_any_number_of_threads() {
    let bench = Bench::with(&[TUBE]);
    bake(&bench, &[TUBE]);
    bench.run(&["report", "@out.crowdpack", "-o", "@report.html"]).expect(0);
    let one = bench.program(&["report", "@out.crowdpack", "-o", "@one.html"]).env("RAYON_NUM_THREADS", "1").status();
    assert!(one.unwrap().success());
    assert!(bench.read("report.html") == bench.read("one.html"));
}

#[test]
fn nothing_is_left_behind_where_something_is_wrong() {
    let bench = Bench::with(&[TRIANGLE]);
    bake(&bench, &[TRIANGLE]);
    let before = bench.listing();
    bench.run(&["report", "@out.crowdpack", "--character", "nobody", "-o", "@r.html"]).expect(1).says(&["`nobody`"]);
    bench.run(&["report", "@gone.crowdpack", "-o", "@r.html"]).expect(1);
    bench.run(&["report", "@out.crowdpack", "-o", "@out.crowdpack"]).expect(2).says(&["is an input too"]);
    bench.run(&["report", "@out.crowdpack", "-o", &format!("@{TRIANGLE}/r.html")]).expect(3);
    bench.run(&["report", "@out.crowdpack"]).expect(2);
    assert_eq!(bench.listing(), before);
    assert!(bench.run(&["-q", "report", &format!("@{TRIANGLE}"), "-o", "@r.html"]).expect(0).err.is_empty());
}

#[test]
fn the_shipped_cast_stays_under_ten_megabytes() {
    let bench = Bench::new();
    let cast = crowd_tests::folders::fixtures().join("cast.toml");
    bench.run(&["-q", "bake", cast.to_str().unwrap(), "-o", "@out.crowdpack"]).expect(0);
    bench.run(&["report", "@out.crowdpack", "-o", "@report.html"]).expect(0);
    let page = page(&bench);
    assert!(page.len() < 10_000_000, "{} bytes", page.len());
    let tags = check(&page);
    assert_eq!(tags.iter().filter(|tag| tag.attribute("class") == Some("sheet")).count(), 14, "two poses each");
}
