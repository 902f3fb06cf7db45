#include "cli/batch/localize_photos.h"

#include <condition_variable>
#include <map>
#include <mutex>
#include <utility>

#include "cli/batch/result_row.h"
#include "core/error.h"
#include "core/parallel_for.h"
#include "http/client.h"

namespace cairn {
namespace {

// Puts rows, which come in any order, into the order of the photos. Safe to use from any thread.
class RowQueue {
 public:
  // A thread may be this many photos ahead of the first unfinished one. Rows of photos ahead take
  // memory, and their work is lost if the process dies.
  static constexpr int64_t kMaxAhead = 64;

  RowQueue(int64_t num_photos, const std::function<void(int64_t, int64_t)>& progress,
           ResultFile* results)
      : num_photos_(num_photos),
        progress_(progress),
        results_(results),
        next_photo_(results->num_rows()) {
    Report();
  }

  // Returns the next photo to work on; num_photos if there is none, or if a thread has failed.
  int64_t Take() {
    std::unique_lock lock(mutex_);
    has_moved_.wait(lock,
                    [this] { return is_over() || next_photo_ < results_->num_rows() + kMaxAhead; });
    return is_over() ? num_photos_ : next_photo_++;
  }

  void Put(int64_t photo_idx, std::string row) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(photo_idx, std::move(row));
    // After a failed write, the end of the file is not known.
    while (!is_writing_ && !waiting_.empty() && waiting_.begin()->first == results_->num_rows()) {
      is_writing_ = true;
      results_->Append(waiting_.begin()->second);
      is_writing_ = false;
      waiting_.erase(waiting_.begin());
      Report();
    }
    has_moved_.notify_all();
  }

  void Fail() {
    const std::lock_guard lock(mutex_);
    has_failed_ = true;
    has_moved_.notify_all();
  }

 private:
  bool is_over() const { return has_failed_ || next_photo_ >= num_photos_; }
  void Report() const {
    if (progress_) {
      progress_(results_->num_rows(), num_photos_);
    }
  }

  const int64_t num_photos_;
  const std::function<void(int64_t, int64_t)>& progress_;
  ResultFile* results_;
  std::mutex mutex_;  // Guards what follows, and the results.
  std::condition_variable has_moved_;
  int64_t next_photo_;
  std::map<int64_t, std::string> waiting_;
  bool is_writing_ = false;
  bool has_failed_ = false;
};

// Whether an error says something about the photo, and not about the map or the server.
bool IsOfPhoto(const Error& error) {
  constexpr int kFirstRefusal = 400, kUnauthorized = 401, kForbidden = 403, kNoSuchPath = 404,
                kTooMany = 429, kFirstOfFronts = 502;
  if (const auto* refusal = dynamic_cast<const ServerRefusal*>(&error)) {
    const int status = refusal->status();
    return status >= kFirstRefusal && status < kFirstOfFronts && status != kUnauthorized &&
           status != kForbidden && status != kNoSuchPath && status != kTooMany &&
           error.code() != ErrorCode::kUnavailable;
  }
  return error.code() != ErrorCode::kUnavailable && error.code() != ErrorCode::kMapDamaged &&
         error.code() != ErrorCode::kConflict;
}

std::string RowOfPhoto(const ListedPhoto& listed, const LocalizePhotosOptions& options,
                       const PhotoAnswerer& answer) {
  PhotoQueryOptions query = options.query;
  if (listed.camera) {
    query.camera = listed.camera;
  }
  if (listed.prior) {
    query.prior = listed.prior;
  }
  bool is_read = false;
  try {
    PhotoQuery photo = ReadPhotoQuery(listed.path, query);
    is_read = true;
    photo.query.id = listed.name;
    const LocalizeResult result = answer(&photo);
    return AnswerRow(listed.name, photo.query, result, options.frame);
  } catch (const Error& error) {
    // Once the photo is read, the file that cannot be read is the map.
    if (!IsOfPhoto(error) || (is_read && error.code() == ErrorCode::kIo)) {
      throw;
    }
    return FailureRow(listed.name, error.what());
  }
}

}  // namespace

void LocalizePhotos(const std::vector<ListedPhoto>& photos, const LocalizePhotosOptions& options,
                    ResultFile* results) {
  const int64_t num_photos = std::ssize(photos);
  RowQueue queue(num_photos, options.progress, results);
  ParallelFor(options.num_threads, options.num_threads, [&](int /*worker*/) {
    try {
      const PhotoAnswerer answer = options.make_answerer();
      for (int64_t i = queue.Take(); i < num_photos; i = queue.Take()) {
        queue.Put(i, RowOfPhoto(photos[static_cast<size_t>(i)], options, answer));
      }
    } catch (...) {
      queue.Fail();
      throw;
    }
  });
}

}  // namespace cairn
