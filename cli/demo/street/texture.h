// A gray texture with independent mip levels along its two axes (a "ripmap").
#ifndef CAIRN_CLI_DEMO_STREET_TEXTURE_H_
#define CAIRN_CLI_DEMO_STREET_TEXTURE_H_

#include <algorithm>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace cairn {

// Facades and pavements are mostly foreshortened along one texture axis. Mip levels that halve u
// and v independently filter such a texture without blurring the other axis. This costs one
// bilinear look-up per sample and four times the memory of the texture. Immutable; safe to use from
// any thread.
class Texture {
 public:
  // The width and height of every texture are multiples of this number, so that all levels halve
  // exactly.
  static constexpr int kSizeStep = 64;
  static constexpr int kNumLevels = 7;  // 1/1 to 1/64.

  // One level, and the relation of its texels to those of the texture.
  struct Level {
    const uint8_t* texels = nullptr;
    int width = 0, height = 0;
    float u_scale = 1.0f, v_scale = 1.0f;  // Level texels per texture texel.

    // Bilinear value at (u, v), in texels of the full texture. The center of the first texel is
    // (0.5, 0.5).
    float Sample(float u, float v) const {
      const float x = std::clamp(u * u_scale - 0.5f, 0.0f, static_cast<float>(width - 1));
      const float y = std::clamp(v * v_scale - 0.5f, 0.0f, static_cast<float>(height - 1));
      const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
      const int x_step = x0 + 1 < width ? 1 : 0;
      const int y_step = y0 + 1 < height ? width : 0;
      const uint8_t* row = texels + static_cast<size_t>(y0) * width + x0;
      const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
      const float top = row[0] + fx * (row[x_step] - row[0]);
      const float bottom = row[y_step] + fx * (row[y_step + x_step] - row[y_step]);
      return top + fy * (bottom - top);
    }
  };

  // `pixels`: CV_8UC1; both sides are multiples of kSizeStep.
  explicit Texture(const cv::Mat& pixels);

  int width() const { return width_; }
  int height() const { return height_; }

  // Returns the level for a sample that covers `u_extent` x `v_extent` texels.
  Level LevelFor(float u_extent, float v_extent) const;

 private:
  int width_;
  int height_;
  std::vector<uint8_t> texels_;
  std::vector<size_t> offsets_;  // kNumLevels x kNumLevels, v level major.
};

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_TEXTURE_H_
