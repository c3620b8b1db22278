// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/encode_png.hpp"

#include <png.h>

namespace tetragauge {

std::string encode_png(std::span<const Colour> pixels, size_t width) {
  if (width == 0 || pixels.empty()) return {};
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(pixels.size() / width);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr)) return {};
  bytes.resize(size);
  return bytes;
}

}  // namespace tetragauge
