//! All pages of a book.

use crate::book::Book;
use crate::page::{Page, page};
use crate::search;

/// The chapters as pages that need nothing but each other, the folder `figures` and, if `opens`, the page of `hangtime play` beside
/// them, in which scenes open; and a page that searches them.
///
/// # Errors
/// A formula that is not understood, and where.
pub fn pages(book: &Book, opens: bool) -> Result<Vec<Page>, String> {
    let places = 0..book.chapters.len();
    let chapters = places.map(|place| page(book, place, opens));
    chapters.chain([search::page(book)]).collect()
}
