#!/usr/bin/env bash
# Checks the dependency rules of the design: which crate may depend on which, and where each outside package may be
# named.
set -euo pipefail
cd "$(dirname "$0")/.."
fail=0
complain() { echo "check-arrows: $*" >&2; fail=1; }

techniques="pathtrace irrcache radcache photonmap ppm instant-radiosity lightcuts"

# Prints the project's packages that a section of a manifest names.
names() { # manifest section
    awk -v section="[$2]" '$0 == section { on = 1; next } /^\[/ { on = 0 } on' "$1" |
        grep -oE '^(gi-[a-z]+|lightcache|vpl|compare|pathtrace|irrcache|radcache|photonmap|ppm|instant-radiosity|lightcuts)\b' || true
}
allow() { # crate allowed...: in its dependencies, whatever its tests name
    local crate=$1 manifest=crates/$1/Cargo.toml name
    shift
    [ -f "$manifest" ] || return 0
    for name in $(names "$manifest" dependencies); do
        case " $* " in *" $name "*) ;; *) complain "$crate may not name $name" ;; esac
    done
}
allow gi-stats
allow gi-page
allow gi-bvh
[ -z "$(names crates/gi-bvh/Cargo.toml dev-dependencies)" ] || complain "tests of gi-bvh may name nothing of the project"
allow gi-core gi-bvh
allow gi-scene gi-core
allow gi-cli gi-core gi-page gi-scene
allow vpl gi-core
allow lightcache gi-core
for technique in $techniques; do
    # The library may name gi-core and one of the two crates that techniques share; the program may also name gi-cli.
    case $technique in
        irrcache | radcache) allow "$technique" gi-core gi-cli lightcache ;;
        instant-radiosity | lightcuts) allow "$technique" gi-core gi-cli vpl ;;
        *) allow "$technique" gi-core gi-cli ;;
    esac
    if [ -d "crates/$technique/src" ] && grep -rlE '\bgi_cli\b' "crates/$technique/src" | grep -v '/main\.rs$'; then
        complain "$technique: only main.rs may name gi_cli"
    fi
done
# compare runs the techniques as programs and names none of their crates.
allow compare gi-core gi-page gi-stats gi-cli
if grep -rlE '\bgi_cli\b' crates/compare/src | grep -v '/main\.rs$'; then
    complain "compare: only main.rs may name gi_cli"
fi

# Each outside package is named in one place.
only() { # package path-pattern
    local hits
    hits=$(grep -rnE "\b$1::" crates/*/src --include='*.rs' | grep -vE "^[^:]*($2)[^:]*:" | grep -vE ':[0-9]+:\s*//' || true)
    [ -z "$hits" ] || complain "$1 is named outside of $2:"$'\n'"$hits"
}
only obvhs 'gi-bvh/src/'
only gi_bvh 'gi-bvh/src/|gi-core/src/'
only tobj 'gi-scene/src/.*obj'
only roxmltree 'gi-scene/src/document'
only annotate_snippets 'gi-scene/src/diagnostics'
only exr 'gi-core/src/image_io/'
only image 'gi-core/src/image_io/'
# Options are declared in params.rs of each technique, or in options.rs if several techniques share them.
only clap 'gi-cli/src/|/src/main\.rs|/src/params\.rs|gi-core/src/options\.rs|lightcache/src/options\.rs|vpl/src/options\.rs'
only indicatif 'gi-cli/src/progress'
only signal_hook 'gi-cli/src/stop'
only rustix 'gi-cli/src/stop'
only tev_client 'gi-cli/src/display'
only humantime 'gi-cli/src/identity'
only clap_complete 'gi-cli/src/help'
only clap_mangen 'gi-cli/src/help'
# gi-cli writes statistics as JSON, and compare reads them; compare's page and --json are JSON too.
only serde_json 'gi-cli/src/|compare/src/'
# Pictures are coloured in Rust by canvas, and on web pages by a table.
only colorous 'gi-core/src/canvas|gi-page/src/lib'
only flate2 'gi-scene/src/|compare/src/planes'
only base64 'compare/src/planes'
only half 'gi-page/src/halves'

# Only gi-bvh may contain unsafe code. The workspace's lints make the compiler forbid it in all other crates.
if grep -rnw unsafe crates tests scripts --include='*.rs' | grep -v '^crates/gi-bvh/'; then
    complain "unsafe code outside of gi-bvh"
fi
for manifest in crates/*/Cargo.toml tests/Cargo.toml scripts/*/Cargo.toml; do
    [ "$manifest" = crates/gi-bvh/Cargo.toml ] || grep -A1 -Fx '[lints]' "$manifest" | grep -qFx 'workspace = true' ||
        complain "$manifest does not take the workspace's lints"
done

exit $fail
