//! What a command printed against what the book shows.

/// Where they differ; see [`crate::Run::difference`].
pub(crate) fn difference(shown: &[String], printed: &str) -> Option<String> {
    let printed: Vec<&str> = printed.lines().filter(|line| !blank(line)).collect();
    let shown: Vec<&str> = shown.iter().map(String::as_str).collect();
    let parts: Vec<Vec<&str>> = shown
        .split(|line| line.trim() == "...")
        .map(|part| part.iter().copied().filter(|line| !blank(line)).collect())
        .collect();
    let mut from = 0;
    for (i, part) in parts.iter().enumerate() {
        let Some(last) = printed.len().checked_sub(part.len()) else {
            return Some(missing(part, 0, &printed));
        };
        let (first, fixed_end) = (i == 0, i + 1 == parts.len());
        let places = match (first, fixed_end) {
            (true, true) if part.len() < printed.len() => {
                return Some(format!("also printed: `{}`", printed[part.len()]));
            }
            (true, _) => 0..=0,
            (false, true) => last.max(from)..=last,
            (false, false) => from..=last,
        };
        let matching = |at: usize| agreeing(part, &printed[at..]);
        let Some(at) = places.clone().find(|at| matching(*at) == part.len()) else {
            let most = places.map(matching).max().unwrap_or(0);
            return Some(missing(part, most, &printed[from.min(printed.len())..]));
        };
        from = at + part.len();
    }
    None
}

fn blank(line: &str) -> bool {
    line.trim().is_empty()
}

/// How many lines at the beginning agree.
fn agreeing(part: &[&str], printed: &[&str]) -> usize {
    let pairs = part.iter().zip(printed);
    pairs.take_while(|(a, b)| same_line(a, b)).count()
}

fn missing(part: &[&str], agree: usize, printed: &[&str]) -> String {
    let line = part.get(agree).copied().unwrap_or("...");
    format!("not printed: `{line}`; printed:\n{}", printed.join("\n"))
}

fn same_line(shown: &str, printed: &str) -> bool {
    let mut printed = printed.split_whitespace();
    shown
        .split_whitespace()
        .all(|word| printed.next().is_some_and(|other| same_word(word, other)))
        && printed.next().is_none()
}

fn same_word(shown: &str, printed: &str) -> bool {
    let number = |word: &str| word.trim_end_matches([',', ';', ':', '.']).parse::<f64>();
    match (number(shown), number(printed)) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-8 + 1e-6 * b.abs(),
        _ => shown == printed,
    }
}
