//! Temporary.
fn main() {
    let file = std::env::args().nth(1).unwrap();
    let text = std::fs::read_to_string(file).unwrap();
    for case in text.split("\u{1}").filter(|case| !case.is_empty()) {
        match motes_formulas::parse(case, "m.toml", &[]) {
            Ok(model) => print!("ACCEPTED {}\u{1}", model.describe()),
            Err(error) => print!("{error}\u{1}"),
        }
    }
}
