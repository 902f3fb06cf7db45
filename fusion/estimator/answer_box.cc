#include "fusion/estimator/answer_box.h"

#include <algorithm>
#include <utility>

namespace cairn::fusion {
namespace {

constexpr size_t kMaxReports = 64;

}  // namespace

SubmitStatus AnswerBox::Submit(Answer answer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (inbox_.size() == kMaxInbox) {
    return SubmitStatus::kQueueFull;
  }
  inbox_.push_back(std::move(answer));
  return SubmitStatus::kQueued;
}

std::vector<Answer> AnswerBox::TakeAll() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (inbox_.empty()) {
      return {};
    }
  }
  std::vector<Answer> answers;
  answers.reserve(kMaxInbox);  // The next inbox. Submit does not wait for the allocation.
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    answers.swap(inbox_);
  }
  std::stable_sort(answers.begin(), answers.end(),
                   [](const Answer& a, const Answer& b) { return a.query_id < b.query_id; });
  return answers;
}

void AnswerBox::Report(const AnswerReport& report) {
  if (reports_.size() == kMaxReports) {
    reports_.pop_front();
  }
  reports_.push_back(report);
}

std::vector<AnswerReport> AnswerBox::TakeReports() {
  std::vector<AnswerReport> reports(reports_.begin(), reports_.end());
  reports_.clear();
  return reports;
}

}  // namespace cairn::fusion
