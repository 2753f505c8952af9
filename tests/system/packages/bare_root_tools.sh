# Sourced by what is tried in a bare Debian root (the scripts bare_root*). Only root can make one,
# with debootstrap and the mirror that this machine's own packages come from.

skip() { echo "skipped: $*"; exit 77; }
quiet() { "$@" > "$work/quiet.log" 2>&1 || { tail -20 "$work/quiet.log"; exit 1; }; }
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive HOME=/root "$@"; }
unmount_root() { if mountpoint -q "$root/proc"; then umount "$root/proc"; fi; }
remove_root() { unmount_root; rm -rf --one-file-system "$work"; }  # never into what is still mounted

# make_bare_root SUITE: a minimal root of bookworm or trixie in $root, with $work beside it; both go when the script ends.
make_bare_root() {
  local mirror
  [ "$(id -u)" = 0 ] || skip "only root can make a root"
  command -v debootstrap > /dev/null || skip "debootstrap is not installed"
  mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE)' 2> /dev/null | awk '$2 == "bookworm" { print $1; exit }')
  [ -n "$mirror" ] || skip "no mirror of Debian 12 among this machine's package sources"
  work=$(mktemp -d "/tmp/sightline_$1.XXXXXX")
  root=$work/root
  trap remove_root EXIT
  debootstrap --variant=minbase "$1" "$root" "$mirror" > "$work/debootstrap.log" 2>&1 || {
    tail -3 "$work/debootstrap.log"
    skip "debootstrap cannot make a root here"
  }
  echo force-unsafe-io > "$root/etc/dpkg/dpkg.cfg.d/unsafe-io"  # the root is thrown away: no package waits for the disk
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  # What tells apt how to reach the mirror from here.
  cp -r /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/"
  mount -t proc proc "$root/proc" || skip "proc cannot be mounted here"
}

# pack GENERATORS: the packages of $build in $work/packages.
pack() { (cd "$build" && quiet cpack -G "$1" -B "$work/packages"); }
