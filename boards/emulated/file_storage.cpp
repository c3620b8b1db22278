// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/file_storage.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>

namespace tetragauge {

static_assert(std::endian::native == std::endian::little, "the file holds the words as they lie in memory");

Result<std::unique_ptr<FileStorage>> FileStorage::open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) return machine_error("--store " + path + ": cannot be opened: " + std::strerror(errno));
  std::unique_ptr<FileStorage> store(new FileStorage(fd));
  const size_t bytes = store->words_.size() * sizeof(uint32_t);
  const ssize_t read = ::pread(fd, store->words_.data(), bytes, 0);
  char beyond = 0;
  const bool whole = read == static_cast<ssize_t>(bytes) && ::pread(fd, &beyond, 1, read) == 0;
  if (read != 0 && !whole) {
    return bad_input("--store " + path + ": is no machine's store (it has " + std::to_string(bytes) +
                     " bytes); choose another file, one that is not there is made");
  }
  if (read == 0 && !store->to_file(0, static_cast<uint32_t>(store->words_.size())))
    return machine_error("--store " + path + ": cannot be written: " + std::strerror(errno));
  return store;
}

FileStorage::~FileStorage() {
  ::close(fd_);
}

bool FileStorage::to_file(uint32_t first_word, uint32_t count) const {
  const size_t bytes = count * sizeof(uint32_t);
  return ::pwrite(fd_, words_.data() + first_word, bytes,
                  static_cast<off_t>(first_word * sizeof(uint32_t))) == static_cast<ssize_t>(bytes);
}

bool FileStorage::erase(uint32_t bank) {
  std::fill_n(words_.begin() + bank * kBankWords, kBankWords, kErasedWord);
  return to_file(bank * kBankWords, kBankWords);
}

bool FileStorage::write(uint32_t bank, uint32_t first_word, const uint32_t* words, uint32_t count) {
  const uint32_t first = bank * kBankWords + first_word;
  for (uint32_t i = 0; i < count; ++i) words_[first + i] &= words[i];
  return to_file(first, count);
}

void FileStorage::read(uint32_t bank, uint32_t first_word, uint32_t* words, uint32_t count) const {
  std::copy_n(words_.begin() + bank * kBankWords + first_word, count, words);
}

}  // namespace tetragauge
