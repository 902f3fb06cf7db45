// Buffers the recent inertial samples and returns them as integration steps between any two times.
#ifndef CAIRN_CORE_INERTIAL_IMU_BUFFER_H_
#define CAIRN_CORE_INERTIAL_IMU_BUFFER_H_

#include <cstdint>
#include <vector>

#include "core/inertial/imu.h"
#include "core/inertial/imu_propagation.h"

namespace cairn::fusion {

// A ring buffer of samples in order of time. Only the constructor allocates. Not thread-safe.
class ImuBuffer {
 public:
  // Holds at most `capacity` samples (at least 2). When the buffer is full, a new sample replaces
  // the oldest.
  explicit ImuBuffer(int capacity) : samples_(static_cast<size_t>(capacity)) {}

  bool empty() const { return size_ == 0; }
  int size() const { return size_; }
  // `idx` counts from the oldest sample.
  const ImuSample& at(int idx) const {
    return samples_[(head_ + static_cast<size_t>(idx)) % samples_.size()];
  }
  int64_t oldest_ns() const { return at(0).timestamp_ns; }
  int64_t newest_ns() const { return at(size_ - 1).timestamp_ns; }

  // `sample` must be newer than all samples in the buffer.
  void Push(const ImuSample& sample);
  void Clear() { size_ = 0; }

  // Removes the samples that no step after `timestamp_ns` needs.
  void DropBefore(int64_t timestamp_ns);

  // Returns true if the samples cover [begin_ns, end_ns].
  bool Covers(int64_t begin_ns, int64_t end_ns) const {
    return size_ > 1 && oldest_ns() <= begin_ns && end_ns <= newest_ns();
  }

  // Interpolates the sample at a time within the buffer linearly.
  ImuSample Interpolate(int64_t timestamp_ns) const;

  // Calls visit(ImuStep) for each step of [begin_ns, end_ns], which the buffer must cover. A step
  // lies between two successive samples and is cut at the ends of the interval. Its reading is the
  // mean of the readings at its two ends.
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
  // Returns the index of the first sample at or after a time; size() if there is none.
  int FirstNotBefore(int64_t timestamp_ns) const;

  std::vector<ImuSample> samples_;
  size_t head_ = 0;
  int size_ = 0;
};

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_INERTIAL_IMU_BUFFER_H_
