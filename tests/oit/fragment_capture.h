// The fragments that a list's strands make, one by one, and their exact composite in double
// precision: what every kind of transparency is measured against.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "oit_test/gpu_structs.h"
#include "oit_test/kernels.h"
#include "pelage/headless.h"
#include "pelage/kernels.h"
#include "pelage/pass_list.h"
#include "pelage/view.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

/// Color that hair adds to a pixel, premultiplied, and the transmittance.
struct ExactPixel {
  double color[3] = {0, 0, 0};
  double transmittance = 1;
  uint32_t fragments = 0;
};

class FragmentCapture {
 public:
  FragmentCapture(ResourceTable& resources, uint32_t capacity)
      : resources_(resources), capacity_(capacity) {
    fragments_ = resources.add({.name = "capture/fragments",
                                .size = uint64_t{capacity} * sizeof(oit_test::CapturedFragment),
                                .stride = sizeof(oit_test::CapturedFragment),
                                .usage = BufferUsage::kStorage | BufferUsage::kReadback});
    count_ = resources.add(
        {.name = "capture/count",
         .size = 16,
         .stride = 4,
         .usage = BufferUsage::kStorage | BufferUsage::kReadback | BufferUsage::kUpload});
  }
  ~FragmentCapture() {
    resources_.remove(fragments_);
    resources_.remove(count_);
  }
  FragmentCapture(const FragmentCapture&) = delete;
  FragmentCapture& operator=(const FragmentCapture&) = delete;

  /// Adds to `to` the draws of smooth ribbons that `from` has, with the same resources, into the
  /// capture. The capture is emptied first.
  /// \param shadowWords Scene::shadowWords()
  void addDraws(const PassList& from, BufferId shadowWords, PassList& to) {
    const uint32_t zeros[4] = {0, 0, 0, 0};
    addUpload(to, count_, std::as_bytes(std::span(zeros)));
    oit_test::CaptureConstants constants = {};
    constants.captureCapacity = capacity_;
    for (const Pass& pass : from.passes) {
      if (pass.kind != PassKind::kDraw) continue;
      const KernelVariant* vertex = vertexOf(pass);
      if (vertex == nullptr) continue;
      DrawState state = pass.state;
      state.colorWrite = false;
      PassBuilder builder(to);
      builder
          .draw(*vertex, oit_test::captureFragmentsVariant({}), state, pass.elementCount,
                pass.instanceCount, pass.indices)
          .vertices(pass.vertices);
      for (const PassBinding& binding : from.bindingsOf(pass)) {
        const LayoutEntry& entry = pass.layouts()[binding.set]->entries[binding.entry];
        if (binding.buffer != BufferId::kInvalid) {
          builder.bind(entry.name, binding.buffer, binding.size, binding.offset);
        } else {
          builder.constants(entry.name,
                            std::span(from.constants).subspan(binding.offset, binding.size));
        }
      }
      builder
          .bind("g_captured", fragments_, uint64_t{capacity_} * sizeof(oit_test::CapturedFragment))
          .bind("g_capturedCount", count_, 16)
          .bind("g_shadowWords", shadowWords, resources_.find(shadowWords)->size)
          .constants("CaptureConstants", constants);
      expectOk(builder.finish());
    }
  }

  std::vector<oit_test::CapturedFragment> read(HeadlessDevice& device) const {
    const auto counts = device.read(count_);
    const auto bytes = device.read(fragments_);
    if (!counts || !bytes) {
      ADD_FAILURE() << "the capture cannot be read";
      return {};
    }
    uint32_t count = 0;
    std::memcpy(&count, counts->data(), sizeof(count));
    EXPECT_LE(count, capacity_) << "the capture is too small";
    std::vector<oit_test::CapturedFragment> fragments(std::min(count, capacity_));
    if (!fragments.empty())
      std::memcpy(fragments.data(), bytes->data(),
                  fragments.size() * sizeof(oit_test::CapturedFragment));
    return fragments;
  }

  /// All fragments of every pixel, front to back.
  static std::vector<ExactPixel> composite(std::vector<oit_test::CapturedFragment> fragments,
                                           const View& view) {
    std::vector<ExactPixel> pixels(size_t{view.width} * view.height);
    const double sign = view.reversedDepth ? -1 : 1;
    std::stable_sort(fragments.begin(), fragments.end(), [&](const auto& a, const auto& b) {
      return sign * static_cast<double>(a.depth) < sign * static_cast<double>(b.depth);
    });
    for (const oit_test::CapturedFragment& f : fragments) {
      if (f.x >= view.width || f.y >= view.height) {
        ADD_FAILURE() << "a fragment outside the view";
        continue;
      }
      ExactPixel& p = pixels[size_t{f.y} * view.width + f.x];
      const double alpha = static_cast<double>(f.alpha);
      const float color[3] = {f.color.x, f.color.y, f.color.z};
      for (int c = 0; c < 3; ++c)
        p.color[c] += p.transmittance * alpha * static_cast<double>(color[c]);
      p.transmittance *= 1 - alpha;
      ++p.fragments;
    }
    return pixels;
  }

 private:
  /// The test's own build of a pass's vertex kernel; nullptr for other kernels than smooth strands.
  static const KernelVariant* vertexOf(const Pass& pass) {
    if (pass.kernel == &strandRecordVertexVariant({.smooth = true}))
      return &oit_test::strandRecordVertexVariant({.smooth = true});
    for (const bool attributes : {false, true}) {
      if (pass.kernel == &strandVertexVariant({.smooth = true, .attributes = attributes}))
        return &oit_test::strandVertexVariant({.smooth = true, .attributes = attributes});
    }
    EXPECT_TRUE(pass.kernel->kernel != strandVertexVariant({}).kernel ||
                pass.kernel == &strandVertexVariant({.smooth = false}))
        << "kernels/manifest.json leaves out the permutation " << pass.kernel->key;
    return nullptr;
  }

  ResourceTable& resources_;
  uint32_t capacity_;
  BufferId fragments_, count_;
};

/// How far a picture over a black, empty target is from the exact composite, over the pixels that
/// have hair.
struct CompositeError {
  double psnr = std::numeric_limits<double>::infinity();  ///< [dB], of 1
  double worst = 0;                                       ///< of a channel, 0..1
  double share = 0;     ///< of the pixels, off by more than 1/255 in a channel
  uint64_t pixels = 0;  ///< that have hair
};

inline CompositeError compositeError(const RenderedImage& image,
                                     const std::vector<ExactPixel>& exact) {
  CompositeError error;
  double sum = 0;
  uint64_t off = 0;
  for (size_t i = 0; i < exact.size(); ++i) {
    if (exact[i].fragments == 0) continue;
    const Float4& seen = image.pixels[i];
    const double difference[4] = {static_cast<double>(seen.x) - exact[i].color[0],
                                  static_cast<double>(seen.y) - exact[i].color[1],
                                  static_cast<double>(seen.z) - exact[i].color[2],
                                  static_cast<double>(seen.w) - (1 - exact[i].transmittance)};
    double largest = 0;
    for (const double d : difference) {
      sum += d * d;
      // A NaN must not hide in max().
      largest = std::abs(d) <= largest ? largest : std::abs(d);
    }
    error.worst = largest <= error.worst ? error.worst : largest;
    off += largest <= 1.0 / 255 ? 0 : 1;
    ++error.pixels;
  }
  if (error.pixels == 0) return error;
  const auto count = static_cast<double>(error.pixels);
  if (sum != 0) error.psnr = -10 * std::log10(sum / (4 * count));
  error.share = static_cast<double>(off) / count;
  return error;
}

}  // namespace pelage::test
