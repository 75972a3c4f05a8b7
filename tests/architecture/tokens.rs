//! Rust source as tokens, without comments and numbers.

/// What the rules need of a source text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Token {
    Word(String),
    Mark(char),
    Text(String),
}

impl Token {
    pub(crate) fn is(&self, mark: char) -> bool {
        *self == Self::Mark(mark)
    }

    pub(crate) fn word(&self) -> Option<&str> {
        match self {
            Self::Word(word) => Some(word),
            _ => None,
        }
    }
}

fn begins_word(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn continues_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The tokens of a source text that compiles.
pub(crate) fn tokens(source: &str) -> Vec<Token> {
    let source: Vec<char> = source.chars().collect();
    let at = |k: usize| source.get(k).copied().unwrap_or('\n');
    let mut tokens = Vec::new();
    let mut k = 0;
    while k < source.len() {
        match at(k) {
            '/' if at(k + 1) == '/' => {
                while k < source.len() && at(k) != '\n' {
                    k += 1;
                }
            }
            '/' if at(k + 1) == '*' => k = after_comment(&source, k),
            '"' => {
                let end = after_string(&source, k);
                tokens.push(Token::Text(source[k + 1..end - 1].iter().collect()));
                k = end;
            }
            // `'a'` and `'\n'` are characters, `'a` is a lifetime
            '\'' if at(k + 1) == '\\' => {
                k += 3;
                while at(k) != '\'' {
                    k += 1;
                }
                k += 1;
            }
            '\'' if at(k + 2) == '\'' => k += 3,
            c if begins_word(c) => {
                if let Some(end) = after_raw_string(&source, k) {
                    tokens.push(Token::Text(String::new()));
                    k = end;
                    continue;
                }
                let from = if c == 'r' && at(k + 1) == '#' {
                    k + 2
                } else {
                    k
                };
                k = from;
                while continues_word(at(k)) {
                    k += 1;
                }
                tokens.push(Token::Word(source[from..k].iter().collect()));
            }
            c if c.is_ascii_digit() => {
                while continues_word(at(k)) {
                    k += 1;
                }
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(Token::Mark(c));
                }
                k += 1;
            }
        }
    }
    tokens
}

/// Block comments nest.
fn after_comment(source: &[char], start: usize) -> usize {
    let mut depth = 0;
    let mut k = start;
    while k + 1 < source.len() {
        match (source[k], source[k + 1]) {
            ('/', '*') => (depth, k) = (depth + 1, k + 2),
            ('*', '/') => (depth, k) = (depth - 1, k + 2),
            _ => k += 1,
        }
        if depth == 0 {
            return k;
        }
    }
    source.len()
}

fn after_string(source: &[char], start: usize) -> usize {
    let mut k = start + 1;
    while k < source.len() && source[k] != '"' {
        k += if source[k] == '\\' { 2 } else { 1 };
    }
    k + 1
}

/// The end of `r"..."`, `r#"..."#` and of their byte and C forms that begin at `start`.
fn after_raw_string(source: &[char], start: usize) -> Option<usize> {
    let mut k = start;
    if matches!(source[k], 'b' | 'c') {
        k += 1;
    }
    if source.get(k) != Some(&'r') {
        return None;
    }
    let hashes = source[k + 1..].iter().take_while(|&&c| c == '#').count();
    k += 1 + hashes;
    if source.get(k) != Some(&'"') {
        return None;
    }
    loop {
        k += 1;
        let closes = *source.get(k)? == '"'
            && source[k + 1..].iter().take_while(|&&c| c == '#').count() >= hashes;
        if closes {
            return Some(k + 1 + hashes);
        }
    }
}
