#include "cli/batch/result_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include "cli/batch/result_row.h"
#include "core/error.h"
#include "core/printable.h"
#include "core/replace_file.h"

namespace cairn {
namespace {

[[noreturn]] void ThrowResultIo(const std::string& path) {
  throw Error(ErrorCode::kIo, fmt::format("{}: {}", Printable(path), std::strerror(errno)));
}

std::string FirstLine(const std::string& digest) {
  return fmt::format("{{\"cairn\":\"localize\",\"rows\":1,\"run\":\"{}\"}}\n", digest);
}

// hloc's readers split lines at blanks.
void RequireHlocNames(const std::string& path, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name.find_first_of(" \t\r\n\v\f") != std::string::npos) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("{}: hloc's lines cannot hold the name '{}', which has a blank; "
                              "write a .csv or .jsonl file",
                              Printable(path), Excerpt(name)));
    }
  }
}

std::string FormattedRow(ResultFormat format, const std::string& name, const std::string& row) {
  switch (format) {
    case ResultFormat::kCsv:
      return CsvOfRow(row);
    case ResultFormat::kJsonl:
      return row + "\n";
    case ResultFormat::kHloc:
      break;
  }
  return HlocOfRow(name, row);
}

}  // namespace

ResultFormat ResultFormatOf(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".csv") {
    return ResultFormat::kCsv;
  }
  if (ending == ".jsonl") {
    return ResultFormat::kJsonl;
  }
  if (ending == ".txt") {
    return ResultFormat::kHloc;
  }
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("--output {}: the name must end in .csv, .jsonl or, for hloc's lines, .txt",
                  Printable(path)));
}

ResultFile::ResultFile(const std::string& path, const std::string& digest,
                       std::vector<std::string> names)
    : path_(path),
      part_path_(path + kUnfinishedSuffix),
      format_(ResultFormatOf(path)),
      names_(std::move(names)) {
  if (format_ == ResultFormat::kHloc) {
    RequireHlocNames(path_, names_);
  }
  Open();
  try {
    Resume(digest);
  } catch (...) {
    close(fd_);
    throw;
  }
}

ResultFile::~ResultFile() { close(fd_); }

void ResultFile::Open() {
  fd_ = open(part_path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd_ < 0) {
    ThrowResultIo(part_path_);
  }
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    close(fd_);
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: another process writes this file", Printable(part_path_)));
  }
}

void ResultFile::Resume(const std::string& digest) {
  const std::string first_line = FirstLine(digest);
  std::ifstream file(part_path_, std::ios::binary);
  std::string line;
  int64_t num_bytes = 0;
  if (std::getline(file, line) && !file.eof() && line + "\n" == first_line) {
    num_bytes = static_cast<int64_t>(first_line.size());
    while (num_rows_ < std::ssize(names_) && std::getline(file, line) && !file.eof() &&
           ReadRow(line)) {
      num_bytes += std::ssize(line) + 1;
      ++num_rows_;
    }
  } else {
    is_restarted_ = !line.empty();
  }
  if (ftruncate(fd_, num_bytes) != 0) {
    ThrowResultIo(part_path_);
  }
  if (num_bytes == 0) {
    Append(first_line.substr(0, first_line.size() - 1));
    num_rows_ = 0;
  }
}

void ResultFile::Append(const std::string& row) {
  const std::string text = row + "\n";
  std::string_view rest = text;
  while (!rest.empty()) {
    const ssize_t num_written = write(fd_, rest.data(), rest.size());
    if (num_written < 0 && errno != EINTR) {
      ThrowResultIo(part_path_);
    }
    rest.remove_prefix(static_cast<size_t>(std::max<ssize_t>(0, num_written)));
  }
  ++num_rows_;
}

ResultCounts ResultFile::Finish() {
  std::ifstream file(part_path_, std::ios::binary);
  FileReplacement output(path_);
  if (format_ == ResultFormat::kCsv) {
    output.Write(CsvHeader());
  }
  ResultCounts counts;
  std::string line;
  std::getline(file, line);  // The digest.
  for (const std::string& name : names_) {
    std::getline(file, line);
    const std::optional<RowSummary> row = ReadRow(line);
    if (!file || !row) {
      throw Error(ErrorCode::kIo,
                  fmt::format("{}: somebody else has changed the file", Printable(part_path_)));
    }
    counts.num_localized += row->localized ? 1 : 0;
    if (!row->localized) {
      ++counts.num_of_reason[row->reason];
    }
    output.Write(FormattedRow(format_, name, line));
  }
  output.Commit();
  unlink(part_path_.c_str());
  return counts;
}

}  // namespace cairn
