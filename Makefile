# Targets for building, testing and documenting the project.
CARGO ?= cargo

.PHONY: all help build test test-slow fuzz asan lint ci book check-readme scenes test-cluster references bench figures compare install man

all: build

# List the targets, one line each.
help:
	@awk '/^$$/ || /^# --/ { text = ""; next } /^# / { text = text (text == "" ? "" : " ") substr($$0, 3) } \
	  /^[a-z][a-z-]*:/ { sub(/:.*/, ""); if (text != "") { sub(/\. .*/, ".", text); printf "%-14s %s\n", $$0, text } text = "" }' \
	  $(MAKEFILE_LIST)
	@echo "figure-N       The figure of slide N, such as figure-12."

# The programs, in target/release. The tools that draw figures are built by the rules that need them.
build:
	$(CARGO) build --release

# The programs' man pages, in target/man.
PROGRAMS = pathtrace irrcache radcache photonmap ppm instant-radiosity lightcuts compare
man: build
	mkdir -p target/man
	for p in $(PROGRAMS); do target/release/$$p --generate man > target/man/$$p.1 || exit 1; done

# The programs with man pages and completions for bash, zsh and fish, below PREFIX.
PREFIX ?= /usr/local
install: man
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/share/man/man1
	install -d $(DESTDIR)$(PREFIX)/share/bash-completion/completions
	install -d $(DESTDIR)$(PREFIX)/share/zsh/site-functions $(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d
	for p in $(PROGRAMS); do \
	  install target/release/$$p $(DESTDIR)$(PREFIX)/bin/ && \
	  install -m 644 target/man/$$p.1 $(DESTDIR)$(PREFIX)/share/man/man1/ && \
	  target/release/$$p --generate bash > $(DESTDIR)$(PREFIX)/share/bash-completion/completions/$$p && \
	  target/release/$$p --generate zsh > $(DESTDIR)$(PREFIX)/share/zsh/site-functions/_$$p && \
	  target/release/$$p --generate fish > $(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d/$$p.fish || exit 1; \
	done

# Quick tests: about thirteen minutes on two cores, less from a warm build.
test:
	$(CARGO) test --workspace

# Slow tests too: hundreds of millions of rays, many seeds.
test-slow:
	$(CARGO) test --workspace --release -- --include-ignored

# Damage files of every kind, and scenes up to their pixels, MINUTES for each kind. First coverage-guided, where there is
# a C++ compiler; then blindly, as the tests do: the kinds share the machine.
MINUTES ?= 10
fuzz:
	scripts/fuzz.sh $$(($(MINUTES) * 60))
	GILAB_FUZZ_SECONDS=$$(($(MINUTES) * 60)) $(CARGO) test --release --workspace --test fuzz -- --nocapture
	GILAB_FUZZ_SECONDS=$$(($(MINUTES) * 60)) $(CARGO) test --release -p gi-cli --lib damaged -- --nocapture

# Tests of the unsafe code and of the loaders under AddressSanitizer.
asan:
	scripts/asan.sh

# Style, lints, documentation, and the dependency rules.
lint:
	$(CARGO) fmt --all -- --check
	$(CARGO) clippy --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --document-private-items
	scripts/check-arrows.sh

# What must pass before a change lands: tests and lints.
ci: test lint

# The pages of docs/ as a book: target/book/index.html. Needs mdBook (`cargo install mdbook`).
book:
	mdbook build docs
	@echo "target/book/index.html"

# Run every command of the README as typed, in a fresh clone: about an hour.
check-readme:
	scripts/check-readme.sh

# Write scenes/ again with the generator.
scenes:
	$(CARGO) run --release -p make-scenes -- scenes

# Try the recipes of scripts/cluster with the schedulers that are installed: a few minutes.
test-cluster: build
	scripts/cluster/test.sh

# Render the references of tests/references again: hours. An interrupted run continues.
references: build
	$(CARGO) run --release -p make-references -- target/release/pathtrace target/references

# Benchmarks, printed as ratios. Path segments per second, and the time of each phase; rays per second against obvhs, and against Embree if EMBREE_LIB is the path of its library; photon
# searches per second against the lecture's layout and kiddo; photons and pixels per second of progressive passes;
# connections per second with virtual point lights against only their shadow rays; cuts against all lights, from 10 to a
# million.
bench:
	$(CARGO) bench -p pathtrace --bench segments
	$(CARGO) bench -p ppm --bench passes
	$(CARGO) bench -p gi-bvh --bench rays $(if $(EMBREE_LIB),--features embree) -- $(BENCH_ARGS)
	$(CARGO) bench -p photonmap --bench search --features rivals
	$(CARGO) bench -p vpl --bench connections
	$(CARGO) bench -p lightcuts --bench scaling
	$(CARGO) bench -p lightcuts --bench cost

# Compare the techniques, COMPARE_TIME each: out/compare/index.html.
COMPARE_TIME ?= 10s
COMPARE_SCENE ?= scenes/cornell-spheres.xml
COMPARE_ARGS ?=
compare: build
	target/release/compare $(COMPARE_SCENE) --time $(COMPARE_TIME) -o out/compare $(COMPARE_ARGS)

# The lecture's figures: one rule per slide.
include scripts/figures.mk

# The pictures of the pages in docs/.
include scripts/pictures.mk
