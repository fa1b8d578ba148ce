#!/usr/bin/env bash
# All tests of the project. Installs software Vulkan (lavapipe) where no driver is found and the system lets us;
# where it cannot, the GPU tests are ignored aloud. CROWD_NO_GPU=1 asks for that on purpose.
set -euo pipefail
cd "$(dirname "$0")/.."

vulkan_driver_found() {
  [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
  for folder in /usr/share/vulkan/icd.d /etc/vulkan/icd.d /usr/local/share/vulkan/icd.d "$HOME/.local/share/vulkan/icd.d"; do
    compgen -G "$folder/*.json" >/dev/null && return 0
  done
  return 1
}

install_software_vulkan() {
  local as_root=""
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null && sudo -n true 2>/dev/null || return 1
    as_root="sudo -n"
  fi
  echo "tests: no Vulkan driver found; installing software Vulkan (lavapipe)" >&2
  if command -v apt-get >/dev/null; then
    $as_root apt-get update -qq && $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq mesa-vulkan-drivers libvulkan1 xvfb
  elif command -v dnf >/dev/null; then
    $as_root dnf install -y -q mesa-vulkan-drivers vulkan-loader
  elif command -v pacman >/dev/null; then
    $as_root pacman -Sy --noconfirm vulkan-swrast vulkan-icd-loader
  else
    return 1
  fi >&2
}

if [ "$(uname -s)" = Linux ] && [ "${CROWD_NO_GPU:-0}" != 1 ] && ! vulkan_driver_found; then
  if ! install_software_vulkan || ! vulkan_driver_found; then
    echo "tests: WARNING: no Vulkan driver and none could be installed: GPU tests are ignored in this run" >&2
    export CROWD_NO_GPU=1
  fi
fi

# The window is tested in a display without a screen.
if [ "$(uname -s)" = Linux ] && [ "${CROWD_NO_GPU:-0}" != 1 ] && ! command -v Xvfb >/dev/null; then
  echo "tests: WARNING: no Xvfb: tests of the window are ignored in this run (install xvfb)" >&2
fi

# Mesa's device-select layer, on by default, complains of a missing XDG_RUNTIME_DIR at every start; we choose no device by it.
export NODEVICE_SELECT=1

# The command-line tests drive the real programs.
cargo build --release --locked -p crowdbake -p crowdplay --bins
cargo test --release --locked --workspace "$@"
