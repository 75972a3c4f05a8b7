//! The page about each mistake holds true: its wrong scene makes this mistake, its right one none.

use crate::mistakes_in;

/// The code block after a line.
fn block<'a>(page: &'a str, heading: &str) -> Option<&'a str> {
    let (_, rest) = page.split_once(&format!("\n{heading}\n"))?;
    let (_, rest) = rest.split_once("```text\n")?;
    Some(rest.split_once("```")?.0)
}

#[test]
fn pages_wrong_scenes_make_the_mistake_and_right_ones_none() {
    let mut checked = 0;
    for code in hangtime_dsl::mistake_codes() {
        let page = hangtime_dsl::explanation(code).unwrap();
        let Some(wrong) = block(page, "Wrong:") else {
            // Found at run time, or not a mistake: nothing to expand.
            assert!(code == "E14", "{code}");
            continue;
        };
        let mistakes = hangtime_dsl::mistakes(wrong.parse().unwrap());
        let codes: Vec<_> = mistakes.iter().map(|mistake| mistake.code).collect();
        assert!(codes.contains(&Some(code)), "{code}: {codes:?}");
        let right = block(page, "Right:").unwrap();
        assert_eq!(mistakes_in(right), ["accepted"], "{code}");
        checked += 1;
    }
    assert_eq!(checked, 26);
}

#[test]
fn page_of_syntax_stands_for_mistakes_without_a_code() {
    let page = hangtime_dsl::explanation(hangtime_dsl::page_name(None)).unwrap();
    let wrong = block(page, "Wrong:").unwrap();
    let mistakes = hangtime_dsl::mistakes(wrong.parse().unwrap());
    let codes: Vec<_> = mistakes.iter().map(|mistake| mistake.code).collect();
    assert_eq!(codes, [None; 3]);
    let right = block(page, "Right:").unwrap();
    assert_eq!(mistakes_in(right), ["accepted"]);
    assert_eq!(hangtime_dsl::page_name(Some("E03")), "E03");
}
