#!/usr/bin/env bash
# The same bytes everywhere: tests/determinism/recipe.toml, a small pair of each region, made in every cell of a matrix of
# processors, profiles, threads and surroundings. A line a cell: its root hash, which stands for every byte of the dataset,
# and whether it is that of the first cell. `./check --long` runs all of it; names choose parts:
#
#   tests/determinism.sh                            everything
#   tests/determinism.sh x86-64-debug surroundings  two parts of it
#
# Parts: {x86-64,x86-64-v3,native}-{debug,release}, surroundings, nehalem, aarch64.
set -euo pipefail
cd "$(dirname "$0")/.."

# What x86-64 means is the target's default: these builds share ./check's own target folder, and no flags may change them.
unset RUSTFLAGS CARGO_ENCODED_RUSTFLAGS
export CARGO_INCREMENTAL=0 CARGO_TERM_COLOR=never

chosen=" $* "
wanted() { [ "$chosen" = "  " ] || [[ "$chosen" == *" $1 "* ]]; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
recipe=$PWD/tests/determinism/recipe.toml
reference="" passed=0 failed=0 skipped=0

skip() { printf '%-52s skipped: %s\n' "$1" "$2"; skipped=$((skipped + 1)); }

# cell NAME COMMAND...: the command makes the dataset in $work/out, where it must not stand yet.
cell() {
    local name=$1 root verdict=same started=$SECONDS
    shift
    if ! root=$("$@" 2>"$work/stderr"); then
        printf '%-52s FAILED: %s\n' "$name" "$(tail -n 3 "$work/stderr" | tr '\n' ' ')"
        failed=$((failed + 1))
    else
        reference=${reference:-$root}
        if [ "$root" = "$reference" ]; then passed=$((passed + 1)); else verdict=DIFFERENT failed=$((failed + 1)); fi
        printf '%-52s %s %s (%ss)\n' "$name" "$root" "$verdict" $((SECONDS - started))
    fi
    rm -rf "$work/out"
}

generate() { # threads, then the program, with whatever runs it before it
    local jobs=$1
    shift
    "$@" generate "$recipe" --out "$work/out" --jobs "$jobs" --quiet
}

# build CPU PROFILE: prints the program's path.
build() {
    local cpu=$1 folder=target flags=()
    [ "$2" = debug ] || flags=(--release)
    if [ "$cpu" = x86-64 ]; then
        cargo build --locked --quiet --bin satseed "${flags[@]}"
    else
        folder=target/matrix/$cpu
        RUSTFLAGS="-C target-cpu=$cpu" CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_DEV_DEBUG=false \
            cargo build --locked --quiet --bin satseed "${flags[@]}" --target-dir "$folder"
    fi
    echo "$PWD/$folder/$2/satseed"
}

# has COMMAND PACKAGE: whether a command is there; on Debian as root it is installed.
has() {
    command -v "$1" >/dev/null && return
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends "${@:2}"; } >/dev/null 2>&1 || true
    command -v "$1" >/dev/null
}

masked=(env 'GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2_Usable,-AVX2')
machine=$(uname -m)

if [ "$machine" = x86_64 ]; then
    # A matrix whose mask nobody feels would prove nothing: the platform's own sine must feel it.
    sines='import math; print(hash(tuple(math.sin(1.1 * i) for i in range(100000))))'
    if [ "$(python3 -c "$sines")" != "$("${masked[@]}" python3 -c "$sines")" ]; then
        echo "the mask is felt here: the platform's sine has other bits under it"
    else
        echo "the mask is not felt here: this processor has no FMA, or this libm does not ask"
    fi
    for profile in debug release; do
        for cpu in x86-64 x86-64-v3 native; do
            wanted "$cpu-$profile" || continue
            if [ "$cpu" = x86-64-v3 ] && ! grep -qw avx2 /proc/cpuinfo; then
                skip "$cpu $profile" "this processor is older than x86-64-v3"
                continue
            fi
            program=$(build "$cpu" "$profile")
            for jobs in 1 2 8; do
                cell "$cpu, $profile, threads $jobs" generate "$jobs" "$program"
                cell "$cpu, $profile, threads $jobs, FMA masked" generate "$jobs" "${masked[@]}" "$program"
            done
        done
    done
else
    for profile in debug release; do
        wanted "native-$profile" || continue
        program=$(build native "$profile")
        for jobs in 1 2 8; do
            cell "$machine native, $profile, threads $jobs" generate "$jobs" "$program"
        done
    done
fi

if wanted surroundings; then
    program=$(build "$([ "$machine" = x86_64 ] && echo x86-64 || echo native)" debug)
    elsewhere() { (cd / && generate 2 env "$@"); }
    cell "another folder, Turkish, Kathmandu's time" elsewhere \
        LC_ALL=tr_TR.UTF-8 LANG=tr_TR.UTF-8 TZ=Asia/Kathmandu TMPDIR=/nowhere HOME=/nowhere "$program"
    if has faketime faketime; then
        cell "the clock in 2001" elsewhere FAKETIME_DONT_FAKE_MONOTONIC=1 faketime '2001-02-03 04:05:06' "$program"
    else
        skip "the clock in 2001" "faketime is not installed"
    fi
    # The matrix can fail: another seed gives another hash.
    other=$("$program" generate "$recipe" --seed 12 --out "$work/other" --jobs 2 --quiet)
    if [ -n "$reference" ] && [ "$other" != "$reference" ]; then
        printf '%-52s %s is another, as it must be\n' "another seed" "$other"
        passed=$((passed + 1))
    else
        printf '%-52s %s is not another: the matrix sees nothing\n' "another seed" "$other"
        failed=$((failed + 1))
    fi
fi

if [ "$machine" = x86_64 ] && wanted nehalem; then
    # No AVX, no FMA, emulated floats. qemu-user has no AVX-512: that path runs in the native cells, where there is one.
    if has qemu-x86_64 qemu-user; then
        program=$(build x86-64 release)
        for jobs in 1 2; do
            cell "x86-64, release, threads $jobs, qemu Nehalem" generate "$jobs" qemu-x86_64 -cpu Nehalem "$program"
        done
    else
        skip "qemu Nehalem" "qemu-user is not installed"
    fi
fi

if [ "$machine" = x86_64 ] && wanted aarch64; then
    target=aarch64-unknown-linux-gnu
    has_target() {
        [ -d "$(rustc --print target-libdir --target "$target")" ] ||
            { command -v rustup >/dev/null && timeout 300 rustup target add "$target" >/dev/null 2>&1; }
    }
    if ! has_target; then
        skip aarch64 "Rust's target $target is not installed and cannot be fetched"
    elif ! has aarch64-linux-gnu-gcc gcc-aarch64-linux-gnu libc6-dev-arm64-cross; then
        skip aarch64 "aarch64-linux-gnu-gcc is not installed"
    elif ! has qemu-aarch64 qemu-user; then
        skip aarch64 "qemu-user is not installed"
    else
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc CARGO_PROFILE_RELEASE_DEBUG=false \
            cargo build --locked --quiet --bin satseed --release --target "$target" --target-dir target/matrix/aarch64
        program=$PWD/target/matrix/aarch64/$target/release/satseed
        for jobs in 1 2; do
            cell "aarch64, release, threads $jobs, qemu" generate "$jobs" \
                qemu-aarch64 -L /usr/aarch64-linux-gnu "$program"
        done
    fi
fi

echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
