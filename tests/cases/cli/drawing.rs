//! The pictures of `inbye plan`.

use std::fs;

use image::RgbaImage;
use roxmltree::{Document, Node};

use super::program::Workplace;

/// Runs a plan with both pictures; returns the exit status, the SVG and the pixels.
#[track_caller]
fn pictures(place: &Workplace, arguments: &str) -> (i32, String, RgbaImage) {
    let run = place.run(&format!("{arguments} --svg plan.svg --png plan.png"));
    assert!(run.errors.is_empty(), "{run:?}");
    let svg = fs::read_to_string(place.path("plan.svg")).expect("the drawing was written");
    let png = image::open(place.path("plan.png")).expect("the pixels were written");
    (run.status, svg, png.into_rgba8())
}

fn with_class<'a>(svg: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    svg.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn texts<'a>(svg: &'a Document) -> Vec<&'a str> {
    svg.descendants()
        .filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")))
        .filter_map(|node| node.text())
        .collect()
}

/// Checks a picture: the SVG is XML without external references or CSS beyond classes; the pixels are 1440 wide with the same
/// aspect ratio.
#[track_caller]
fn check(svg: &str, pixels: &RgbaImage) {
    let drawing = Document::parse(svg).expect("the drawing is XML");
    let root = drawing.root_element();
    let side = |name: &str| -> f64 {
        let text = root.attribute(name).expect("the drawing has a size");
        text.parse().expect("a side is a number")
    };
    let expected = (1440, (2.0 * side("height")).ceil() as u32);
    assert_eq!(pixels.dimensions(), expected);
    for outside in ["var(", "url(", "@", "http", "NaN", "inf\""] {
        let own = svg.replace("http://www.w3.org/2000/svg", "");
        assert!(!own.contains(outside), "the drawing holds {outside}");
    }
    let links = drawing.descendants().filter_map(|node| node.attribute("href"));
    assert!(links.into_iter().all(|link| link.starts_with("data:")));
    let (mut ink, mut paper) = (0, 0);
    for pixel in pixels.pixels() {
        let [red, green, blue, opacity] = pixel.0;
        assert_eq!(opacity, 255, "an opaque picture");
        ink += u32::from(red < 80 && green < 80 && blue < 80);
        paper += u32::from([red, green, blue] == [255; 3]);
    }
    // Letters, marks and free cells.
    assert!(ink > 1000 && paper > 10_000, "{ink} and {paper}");
}

#[test]
fn plan_is_drawn_on_map() {
    let place = Workplace::new();
    let (status, svg, pixels) = pictures(
        &place,
        "plan --map mine.yaml --start 10,5,1.5 --via 20,30 --via 60,50 --goal 80,40",
    );
    assert_eq!(status, 0);
    check(&svg, &pixels);
    let drawing = Document::parse(&svg).unwrap();
    for stage in ["searched", "pruned", "smoothed"] {
        let lines = with_class(&drawing, stage);
        let drawn = lines.iter().filter(|line| line.tag_name().name() == "polyline");
        assert_eq!(drawn.count(), 1, "{stage}");
    }
    let texts = texts(&drawing);
    for text in ["start", "goal", "1", "2", "smoothed path", "obstacle", "x", "y"] {
        assert!(texts.contains(&text), "no {text:?} in {texts:?}");
    }
    let caption = texts.iter().find(|text| text.contains(" m long"));
    let caption = caption.expect("a caption");
    for words in ["2 stops", "turns before smoothing", "clearance at least"] {
        assert!(caption.contains(words), "{caption}");
    }
    assert!(texts.iter().any(|text| text.contains("mine.yaml")));
    // Only the smoothed path is green.
    let is_green = |[red, green, blue, _]: [u8; 4]| {
        u16::from(green) > u16::from(red) + 40 && u16::from(green) > u16::from(blue) + 10
    };
    let green = pixels.pixels().filter(|pixel| is_green(pixel.0)).count();
    assert!(green > 3000, "{green} pixels of the smoothed path");
}

#[test]
fn letters_are_rendered_without_system_fonts() {
    let place = Workplace::new();
    let (_, _, pixels) = pictures(&place, "plan --map mine.yaml --start 10,5 --goal 80,40");
    // The band of the title contains letters only.
    let dark = |pixel: &image::Rgba<u8>| pixel.0[0] < 120;
    let headline = (0..1440).flat_map(|x| (20..60).map(move |y| (x, y)));
    let ink = headline.filter(|&(x, y)| dark(pixels.get_pixel(x, y))).count();
    assert!(ink > 500, "{ink} dark pixels");
}

#[test]
fn same_plan_gives_same_bytes() {
    let place = Workplace::new();
    let arguments = "plan --map mine.yaml --start 10,5 --goal 80,40";
    let one = pictures(&place, arguments);
    assert!(one == pictures(&place, arguments));
}

#[test]
fn unusual_maps_are_drawn() {
    let place = Workplace::new();
    place.write("empty.txt", "........\n........\n........\n");
    place.write("dot.txt", ".\n");
    place.write("unseen.txt", "....??\n....??\n.#..??\n");
    place.write("tall.txt", ".\n".repeat(500));
    let yaml = fs::read_to_string(place.path("mine.yaml")).unwrap();
    place.write("turned.yaml", yaml.replace("[0.0, 0.0, 0.0]", "[-20.0, 5.0, 0.6]"));
    for arguments in [
        "--map empty.txt --start 1,1 --goal 7,2 --radius 0",
        "--map empty.txt --start 4,1 --goal 4,1 --radius 0",
        "--map dot.txt --start 0.5,0.5 --goal 0.5,0.5 --radius 0",
        "--map unseen.txt --start 0.5,1.5 --goal 3.5,0.5 --radius 0",
        "--map tall.txt --start 0.5,1.5 --goal 0.5,480 --radius 0",
        "--map turned.yaml --start -15,15 --goal 20,65",
    ] {
        let (status, svg, pixels) = pictures(&place, &format!("plan {arguments}"));
        assert_eq!(status, 0, "{arguments}");
        check(&svg, &pixels);
        let drawing = Document::parse(&svg).unwrap();
        let explains_unknown = texts(&drawing).contains(&"unknown");
        assert_eq!(explains_unknown, arguments.contains("unseen"));
        assert_eq!(
            svg.contains("no obstacle on the map"),
            arguments.contains("empty") || arguments.contains("dot") || arguments.contains("tall")
        );
    }
}

#[test]
fn failed_plan_is_drawn() {
    let place = Workplace::new();
    place.write("halves.txt", "#######\n#..#..#\n#..#..#\n#######\n");
    let (status, svg, pixels) = pictures(
        &place,
        "plan --map halves.txt --start 1.5,1.5 --via 2.5,2.5 --goal 4.5,1.5 --radius 0",
    );
    assert_eq!(status, 1);
    check(&svg, &pixels);
    let drawing = Document::parse(&svg).unwrap();
    assert!(texts(&drawing).contains(&"no path to the goal (NO_VALID_PATH)"), "{svg}");
    assert!(texts(&drawing).contains(&"nearest reachable point"));
    // The planned leg.
    assert!(!with_class(&drawing, "smoothed").is_empty());

    // An occupied goal is drawn as well.
    place.refusal("plan --map halves.txt --start 1.5,1.5 --goal 3.5,1.5 --radius 0 --svg plan.svg");
    let svg = fs::read_to_string(place.path("plan.svg")).unwrap();
    assert!(svg.contains("no path to the goal (GOAL_OCCUPIED)"));
}

#[test]
fn markup_in_map_name_is_escaped() {
    let place = Workplace::new();
    let name = "a&b<c>.txt";
    place.write(name, "....\n....\n");
    let (status, svg, pixels) =
        pictures(&place, &format!("plan --map {name} --start 1,1 --goal 3,1 --radius 0"));
    assert_eq!(status, 0);
    check(&svg, &pixels);
}
