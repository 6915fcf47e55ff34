# ARGS is handed on: make run ARGS="--tolerance 1e-2", make test ARGS="--test gpu".
.PHONY: help run test test-python build wheel setup lint measure book release clean

ARGS =
export PATH := $(PATH):$(or $(CARGO_HOME),$(HOME)/.cargo)/bin

help:
	@echo 'make run     build diffract and show it: a window, or diffract.png where there is no display'
	@echo 'make test    all tests, on the CPU with lavapipe, with Vulkan validation'
	@echo 'make test-python  tests of the Python module; ARGS="-k orders" for some of them'
	@echo 'make build   target/release/diffract'
	@echo 'make wheel   the Python module with the program, for pip install, into target/wheels'
	@echo 'make setup   get what the above need; each of them does so by itself'
	@echo 'make lint    formatting, clippy and rustdoc, warnings denied'
	@echo 'make measure speed against accuracy on this machine, into docs/BENCHMARKS.md; ARGS=--check compares instead'
	@echo 'make book    commands and pictures of the book in docs/; as HTML in target/book where mdbook is installed'
	@echo 'make release an archive for x86-64 Linux in target/archive, with completions, pages for man and licences'
	@echo 'make clean   remove what was built'

run:
	@tools/setup.sh run
	@tools/run.sh $(ARGS)

test:
	@tools/setup.sh test
	@tools/test.sh $(ARGS)

test-python:
	@tools/setup.sh test python
	@tools/python.sh test $(ARGS)

build:
	@tools/setup.sh build
	cargo build --release --locked

wheel:
	@tools/setup.sh build python
	@tools/python.sh wheel

setup:
	@tools/setup.sh run test

lint:
	@tools/setup.sh build
	cargo fmt --all --check
	PYO3_BUILD_EXTENSION_MODULE=1 PYO3_NO_PYTHON=1 cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --no-deps --locked

measure: build
	rm -rf target/trade
	target/release/diffract trade --quick -o target/trade
	@tools/measure.py target/trade $(ARGS)

book: build
	@tools/book.sh $(ARGS)
	@if command -v mdbook >/dev/null; then mdbook build && python3 tools/links.py target/book; else echo 'mdbook is not installed: no HTML (cargo install mdbook --locked)'; fi

release:
	@tools/release.sh $(ARGS)

clean:
	cargo clean
