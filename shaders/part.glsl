// Wavelengths that an invocation sums: every `step`th from `first`. The Rust side is src/render/source/part.rs.
struct Part {
    int first;
    int step;
};
