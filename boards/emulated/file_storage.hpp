// SPDX-License-Identifier: Apache-2.0
// The emulated board's store in a file, so that a calibration outlives the program: both banks as
// little-endian words. Each change is in the file before the call returns.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware/hal/storage.hpp"
#include "host/base/result.hpp"

namespace tetragauge {

class FileStorage : public Storage {
 public:
  static constexpr uint32_t kBankWords = 1024;

  // A file that is not there begins as an erased store.
  static Result<std::unique_ptr<FileStorage>> open(const std::string& path);
  ~FileStorage();
  FileStorage(const FileStorage&) = delete;
  FileStorage& operator=(const FileStorage&) = delete;

  uint32_t bank_words() const override { return kBankWords; }
  bool erase(uint32_t bank) override;
  bool write(uint32_t bank, uint32_t first_word, const uint32_t* words, uint32_t count) override;
  bool busy() const override { return false; }
  void read(uint32_t bank, uint32_t first_word, uint32_t* words, uint32_t count) const override;

 private:
  explicit FileStorage(int fd) : fd_(fd), words_(kBanks * kBankWords, kErasedWord) {}
  bool to_file(uint32_t first_word, uint32_t count) const;

  int fd_;
  std::vector<uint32_t> words_;
};

}  // namespace tetragauge
