#!/usr/bin/env bash
# All tests of the project. Installs software Vulkan (lavapipe) where no driver is found and the system lets us, and Xvfb alike;
# where it cannot, tests of the GPU or of the window are ignored aloud. CROWD_NO_GPU=1, CROWD_NO_DISPLAY=1 ask for that on purpose.
set -euo pipefail
cd "$(dirname "$0")/.."

vulkan_driver_found() {
  [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
  for folder in /usr/share/vulkan/icd.d /etc/vulkan/icd.d /usr/local/share/vulkan/icd.d "$HOME/.local/share/vulkan/icd.d"; do
    compgen -G "$folder/*.json" >/dev/null && return 0
  done
  return 1
}

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else command -v sudo >/dev/null && sudo -n true 2>/dev/null && sudo -n "$@"; fi
}

# install WHAT DEBIAN FEDORA ARCH: what it is in words, and the packages that have it there. Fails where nothing can be installed.
install() {
  as_root true || return 1
  echo "tests: installing $1" >&2
  # Names of packages are several words each.
  # shellcheck disable=SC2086
  if command -v apt-get >/dev/null; then
    as_root timeout 300 apt-get -o Acquire::http::Timeout=20 update -qq && as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $2
  elif command -v dnf >/dev/null; then
    as_root dnf install -y -q $3
  elif command -v pacman >/dev/null; then
    as_root pacman -Sy --noconfirm $4
  else
    return 1
  fi >&2
}

if [ "$(uname -s)" = Linux ] && [ "${CROWD_NO_GPU:-0}" != 1 ] && ! vulkan_driver_found; then
  if ! install "software Vulkan (lavapipe): no driver found" "mesa-vulkan-drivers libvulkan1" "mesa-vulkan-drivers vulkan-loader" \
    "vulkan-swrast vulkan-icd-loader" || ! vulkan_driver_found; then
    echo "tests: WARNING: no Vulkan driver and none could be installed: GPU tests are ignored in this run" >&2
    export CROWD_NO_GPU=1
  fi
fi

# The window is tested in a display without a screen; a window loads its libraries when it opens.
display_found() {
  command -v Xvfb >/dev/null || return 1
  local libraries library
  libraries=$(PATH="$PATH:/usr/sbin:/sbin" ldconfig -p 2>/dev/null) || return 0
  for library in libX11.so.6 libX11-xcb.so.1 libXcursor.so.1 libXi.so.6 libxcb.so.1 libxkbcommon.so.0 libxkbcommon-x11.so.0; do
    [[ $libraries == *"$library"* ]] || return 1
  done
}

if [ "$(uname -s)" = Linux ] && [ "${CROWD_NO_GPU:-0}" != 1 ] && [ "${CROWD_NO_DISPLAY:-0}" != 1 ] && ! display_found; then
  if ! install "a display for tests (Xvfb)" "xvfb libx11-6 libx11-xcb1 libxcursor1 libxi6 libxcb1 libxkbcommon0 libxkbcommon-x11-0" \
    "xorg-x11-server-Xvfb libX11 libX11-xcb libXcursor libXi libxcb libxkbcommon libxkbcommon-x11" \
    "xorg-server-xvfb libx11 libxcursor libxi libxcb libxkbcommon libxkbcommon-x11" || ! display_found; then
    echo "tests: WARNING: no Xvfb, or no X11 libraries, and none could be installed: tests of the window are ignored in this run" >&2
    export CROWD_NO_DISPLAY=1
  fi
fi

# Mesa's device-select layer, on by default, complains of a missing XDG_RUNTIME_DIR at every start; we choose no device by it.
export NODEVICE_SELECT=1

# The command-line tests drive the real programs.
cargo build --release --locked -p crowdbake -p crowdplay --bins
cargo test --release --locked --workspace "$@"
