#include "fusion/estimator/answer_box.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace cairn::fusion {
namespace {

constexpr size_t kMaxReports = 64;

}  // namespace

SubmitStatus AnswerBox::Submit(Answer answer) {
  if (!has_room()) {
    return SubmitStatus::kQueueFull;
  }
  inbox_.push_back(std::move(answer));
  return SubmitStatus::kQueued;
}

std::vector<Answer> AnswerBox::TakeAll() {
  std::vector<Answer> answers(std::make_move_iterator(inbox_.begin()),
                              std::make_move_iterator(inbox_.end()));
  inbox_.clear();
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
