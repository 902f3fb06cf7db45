// Holds the answers that wait for the next frame, and the reports on earlier answers.
#ifndef CAIRN_FUSION_ESTIMATOR_ANSWER_BOX_H_
#define CAIRN_FUSION_ESTIMATOR_ANSWER_BOX_H_

#include <deque>
#include <mutex>
#include <vector>

#include "fusion/estimator/fusion_types.h"

namespace cairn::fusion {

// Submit may be called from any thread; it does not allocate, and waits for no longer than the move
// of one answer takes. Call all else from one thread.
class AnswerBox {
 public:
  AnswerBox() { inbox_.reserve(kMaxInbox); }

  // Refuses the answer while 32 answers wait.
  SubmitStatus Submit(Answer answer);

  // Removes and returns all answers, in the order of their queries, so that the order of arrival
  // does not matter.
  std::vector<Answer> TakeAll();

  void Report(const AnswerReport& report);

  // Removes and returns the reports since the last call, at most the last 64.
  std::vector<AnswerReport> TakeReports();

 private:
  static constexpr size_t kMaxInbox = 32;

  std::mutex mutex_;
  std::vector<Answer> inbox_;  // Guarded by mutex_.
  std::deque<AnswerReport> reports_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_ANSWER_BOX_H_
