// The output of `cairn localize --images`, written so that a killed run can go on.
#ifndef CAIRN_CLI_BATCH_RESULT_FILE_H_
#define CAIRN_CLI_BATCH_RESULT_FILE_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cairn {

enum class ResultFormat {
  kCsv,    // .csv
  kJsonl,  // .jsonl: a row a line.
  kHloc,   // .txt: hloc's lines; photos without a pose have none.
};

// Returns the format by the end of the name. Throws Error(kInvalidArgument) for another.
ResultFormat ResultFormatOf(const std::string& path);

struct ResultCounts {
  int64_t num_localized = 0;
  std::map<std::string, int64_t> num_of_reason;  // Of the photos without a pose.
};

// Rows are collected in `path` + ".part", in the order of the photos: a first line with the digest
// of the run, then a row a line. Finish makes `path` of them, all of it or nothing. A process that
// dies leaves the complete rows, and the next run with the same digest goes on behind them. Use
// from one thread.
class ResultFile {
 public:
  // `digest` names everything that rows depend on. Throws Error(kConflict) if another process
  // writes the same output, Error(kIo), and Error(kBadInput) if hloc's form cannot hold a name.
  ResultFile(const std::string& path, const std::string& digest, std::vector<std::string> names);
  ~ResultFile();
  ResultFile(const ResultFile&) = delete;
  ResultFile& operator=(const ResultFile&) = delete;

  int64_t num_rows() const { return num_rows_; }  // Photos that need not be asked again.
  // Rows of another run were dropped: other photos, another map or other options.
  bool is_restarted() const { return is_restarted_; }

  // Appends the row of the next photo; the file has it when the call returns. Throws Error(kIo).
  void Append(const std::string& row);

  // Writes the output, to the disk, and deletes the rows. All photos must have a row.
  ResultCounts Finish();

 private:
  void Open();
  // Keeps what can be kept of an earlier run: the file ends with a complete row afterwards.
  void Resume(const std::string& digest);

  std::string path_;
  std::string part_path_;
  ResultFormat format_;
  std::vector<std::string> names_;
  int fd_ = -1;
  int64_t num_rows_ = 0;
  bool is_restarted_ = false;
};

}  // namespace cairn

#endif  // CAIRN_CLI_BATCH_RESULT_FILE_H_
