//! What a diagram shows, and how it is drawn: as SVG here. Knows no file, no flight and no analysis; builds for a browser too.

pub mod svg;
