// The recent inertial samples, as steps between any two instants.
#ifndef CAIRN_FUSION_FILTER_IMU_BUFFER_H_
#define CAIRN_FUSION_FILTER_IMU_BUFFER_H_

#include <cstdint>
#include <vector>

#include "fusion/filter/imu.h"
#include "fusion/filter/imu_propagation.h"

namespace cairn::fusion {

// A ring of samples in order of time. Allocates only in the constructor. Not thread-safe.
class ImuBuffer {
 public:
  // Holds at most `capacity` samples (at least 2); the oldest make way.
  explicit ImuBuffer(int capacity) : samples_(static_cast<size_t>(capacity)) {}

  bool empty() const { return size_ == 0; }
  int size() const { return size_; }
  // `idx` counts from the oldest sample.
  const ImuSample& at(int idx) const {
    return samples_[(head_ + static_cast<size_t>(idx)) % samples_.size()];
  }
  int64_t oldest_ns() const { return at(0).timestamp_ns; }
  int64_t newest_ns() const { return at(size_ - 1).timestamp_ns; }

  // `sample` must be newer than the newest.
  void Push(const ImuSample& sample);
  void Clear() { size_ = 0; }

  // Forgets samples that no step from `timestamp_ns` on needs.
  void DropBefore(int64_t timestamp_ns);

  // True if steps over [begin_ns, end_ns] can be formed.
  bool Covers(int64_t begin_ns, int64_t end_ns) const {
    return size_ > 1 && oldest_ns() <= begin_ns && end_ns <= newest_ns();
  }

  // The sample at an instant within the buffer, interpolated linearly.
  ImuSample Interpolate(int64_t timestamp_ns) const;

  // Calls visit(ImuStep) over [begin_ns, end_ns], which must be covered: one step between
  // successive samples, cut at the ends, with the mean of the readings at its two ends.
  template <typename Visitor>
  void ForEachStep(int64_t begin_ns, int64_t end_ns, const Visitor& visit) const {
    if (begin_ns >= end_ns) {
      return;
    }
    int idx = FirstNotBefore(begin_ns + 1);
    ImuSample previous = Interpolate(begin_ns);
    while (previous.timestamp_ns < end_ns) {
      const ImuSample next = at(idx).timestamp_ns <= end_ns ? at(idx) : Interpolate(end_ns);
      visit(ImuStep{0.5 * (previous.gyro_rad_s + next.gyro_rad_s),
                    0.5 * (previous.accel_m_s2 + next.accel_m_s2),
                    1e-9 * static_cast<double>(next.timestamp_ns - previous.timestamp_ns)});
      previous = next;
      ++idx;
    }
  }

 private:
  // Index of the first sample at or after an instant; size() if none.
  int FirstNotBefore(int64_t timestamp_ns) const;

  std::vector<ImuSample> samples_;
  size_t head_ = 0;
  int size_ = 0;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_IMU_BUFFER_H_
