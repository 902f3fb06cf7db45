#include "core/inertial/imu_buffer.h"

#include "core/check.h"

namespace cairn::fusion {

void ImuBuffer::Push(const ImuSample& sample) {
  CAIRN_CHECK(empty() || sample.timestamp_ns > newest_ns(), "samples come in order of time");
  const int capacity = static_cast<int>(samples_.size());
  if (size_ == capacity) {
    head_ = (head_ + 1) % samples_.size();
    --size_;
  }
  samples_[(head_ + static_cast<size_t>(size_)) % samples_.size()] = sample;
  ++size_;
}

void ImuBuffer::DropBefore(int64_t timestamp_ns) {
  while (size_ > 1 && at(1).timestamp_ns <= timestamp_ns) {
    head_ = (head_ + 1) % samples_.size();
    --size_;
  }
}

int ImuBuffer::FirstNotBefore(int64_t timestamp_ns) const {
  int low = 0;
  int high = size_;
  while (low < high) {
    const int middle = (low + high) / 2;
    if (at(middle).timestamp_ns < timestamp_ns) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

ImuSample ImuBuffer::Interpolate(int64_t timestamp_ns) const {
  const int idx = FirstNotBefore(timestamp_ns);
  CAIRN_CHECK(idx < size_, "the instant lies within the buffer");
  const ImuSample& after = at(idx);
  if (after.timestamp_ns == timestamp_ns) {
    return after;
  }
  CAIRN_CHECK(idx > 0, "the instant lies within the buffer");
  const ImuSample& before = at(idx - 1);
  const double weight = static_cast<double>(timestamp_ns - before.timestamp_ns) /
                        static_cast<double>(after.timestamp_ns - before.timestamp_ns);
  return {timestamp_ns, before.gyro_rad_s + weight * (after.gyro_rad_s - before.gyro_rad_s),
          before.accel_m_s2 + weight * (after.accel_m_s2 - before.accel_m_s2)};
}

}  // namespace cairn::fusion
