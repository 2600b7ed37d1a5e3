#!/usr/bin/env bash
# Hold the arrows of the design: who may depend on whom, and where each outside package may be named.
set -euo pipefail
cd "$(dirname "$0")/.."
fail=0
complain() { echo "check-arrows: $*" >&2; fail=1; }

techniques="pathtrace irrcache radcache photonmap ppm instant-radiosity lightcuts"

# Packages of the project that a manifest's section names.
names() { # manifest section
    awk -v section="[$2]" '$0 == section { on = 1; next } /^\[/ { on = 0 } on' "$1" |
        grep -oE '^(gi-[a-z]+|vpl|compare|pathtrace|irrcache|radcache|photonmap|ppm|instant-radiosity|lightcuts)\b' || true
}
allow() { # crate allowed...
    local crate=$1 manifest=crates/$1/Cargo.toml name
    shift
    [ -f "$manifest" ] || return 0
    for name in $(names "$manifest" dependencies); do
        case " $* " in *" $name "*) ;; *) complain "$crate may not name $name" ;; esac
    done
}
allow gi-stats
allow gi-core
allow gi-scene gi-core
allow gi-cli gi-core gi-scene
allow vpl gi-core
for technique in $techniques; do
    # The library names gi-core and vpl; the program besides it gi-cli.
    allow "$technique" gi-core gi-cli vpl
    if [ -d "crates/$technique/src" ] && grep -rlE '\bgi_cli\b' "crates/$technique/src" | grep -v '/main\.rs$'; then
        complain "$technique: only main.rs may name gi_cli"
    fi
done
# It runs the techniques as programs and names none of them.
allow compare gi-core gi-stats gi-cli
if grep -rlE '\bgi_cli\b' crates/compare/src | grep -v '/main\.rs$'; then
    complain "compare: only main.rs may name gi_cli"
fi

# Each outside package is named in one place.
only() { # package path-pattern
    local hits
    hits=$(grep -rnE "\b$1::" crates/*/src --include='*.rs' | grep -vE "^[^:]*($2)[^:]*:" | grep -vE ':[0-9]+:\s*//' || true)
    [ -z "$hits" ] || complain "$1 is named outside of $2:"$'\n'"$hits"
}
only obvhs 'gi-core/src/bvh/'
only tobj 'gi-scene/src/.*obj'
only roxmltree 'gi-scene/src/document'
only annotate_snippets 'gi-scene/src/diagnostics'
only exr 'gi-core/src/image_io/'
only image 'gi-core/src/image_io/'
# Options are stated in params.rs of the techniques, and in options.rs where several techniques share them.
only clap 'gi-cli/src/|/src/main\.rs|/src/params\.rs|gi-core/src/options\.rs|gi-core/src/cache/options\.rs|vpl/src/options\.rs'
only indicatif 'gi-cli/src/progress'
# Statistics are written by gi-cli and read by compare, whose page and --json are JSON as well.
only serde_json 'gi-cli/src/|compare/src/'
# Pictures are coloured in Rust by canvas, in a page by a table that it carries.
only colorous 'gi-core/src/canvas|compare/src/page/'
only flate2 'gi-scene/src/|compare/src/planes'
only base64 'compare/src/planes'
only half 'compare/src/planes'

exit $fail
