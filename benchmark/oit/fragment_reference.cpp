#include "oit/fragment_reference.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"
#include "oit/strand_draws.h"

namespace bench {

using baseline::SampledFragment;
using pelage::BufferUsage;
using pelage::Float4;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::RenderedImage;
using pelage::Result;

namespace {

// Fragments of each pixel of the sampled rows, front to back, over the picture without hair.
ExactPicture composite(std::span<const SampledFragment> fragments, const RenderedImage& behind) {
  const size_t count = size_t{behind.width} * behind.height;
  const auto pixelOf = [&](const SampledFragment& f) { return size_t{f.y} * behind.width + f.x; };
  std::vector<uint32_t> starts(count + 1);
  for (const SampledFragment& f : fragments) ++starts[pixelOf(f) + 1];
  for (size_t i = 0; i < count; ++i) starts[i + 1] += starts[i];
  std::vector<uint32_t> order(fragments.size()), next(starts.begin(), starts.end() - 1);
  for (uint32_t i = 0; i < fragments.size(); ++i) order[next[pixelOf(fragments[i])]++] = i;

  ExactPicture exact;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t layers = starts[i + 1] - starts[i];
    if (layers == 0) continue;
    exact.layersMax = std::max(exact.layersMax, layers);
    const auto begin = order.begin() + starts[i], end = order.begin() + starts[i + 1];
    std::sort(begin, end, [&](uint32_t a, uint32_t b) {
      return fragments[a].depth != fragments[b].depth ? fragments[a].depth < fragments[b].depth
                                                      : a < b;
    });
    ExactPicture::Pixel pixel = {static_cast<uint32_t>(i), {0, 0, 0}};
    double through = 1;
    const auto add = [&](const Float4& color, double alpha) {
      pixel.color[0] += through * alpha * static_cast<double>(color.x);
      pixel.color[1] += through * alpha * static_cast<double>(color.y);
      pixel.color[2] += through * alpha * static_cast<double>(color.z);
      through *= 1 - alpha;
    };
    for (auto f = begin; f != end; ++f)
      add(fragments[*f].color, static_cast<double>(fragments[*f].alpha));
    add(behind.pixels[i], 1);
    exact.pixels.push_back(pixel);
  }
  if (!exact.pixels.empty())
    exact.layersMean =
        static_cast<double>(fragments.size()) / static_cast<double>(exact.pixels.size());
  return exact;
}

}  // namespace

FragmentReference::FragmentReference(HairScene& scene, uint32_t limit)
    : scene_(scene),
      limit_(static_cast<uint32_t>(std::min<uint64_t>(
          limit, scene.device().info().maxBufferBytes / sizeof(SampledFragment)))) {
  fragments_ = scene.resources().add({.name = "reference/fragments",
                                      .size = uint64_t{limit_} * sizeof(SampledFragment),
                                      .stride = sizeof(SampledFragment),
                                      .usage = BufferUsage::kStorage | BufferUsage::kReadback});
  counts_ = scene.resources().add(
      {.name = "reference/counts",
       .size = 16,
       .stride = 4,
       .usage = BufferUsage::kStorage | BufferUsage::kReadback | BufferUsage::kUpload});
}

FragmentReference::~FragmentReference() {
  scene_.resources().remove(fragments_);
  scene_.resources().remove(counts_);
}

Result<ExactPicture> FragmentReference::picture(const pelage::View& view) {
  baseline::SampleFragmentsConstants constants = {};
  constants.sampleCapacity = limit_;
  constants.sampleRowStep = 1;
  for (;;) {
    auto strands = strandLists(scene_, view);
    if (!strands) return strands.error();
    std::vector<PassList> lists(2);
    copyOtherPasses((*strands)[0], lists[0]);
    const uint32_t zeros[4] = {0, 0, 0, 0};
    addUpload(lists[0], counts_, std::as_bytes(std::span(zeros)));
    const auto offer = [&](PassBuilder& builder) {
      builder.bind("g_sampled", fragments_, uint64_t{limit_} * sizeof(SampledFragment))
          .bind("g_sampledCounts", counts_, 16)
          .bind("g_shadowWords", scene_.shadowWords(),
                scene_.resources().find(scene_.shadowWords())->size)
          .constants("SampleFragmentsConstants", constants);
    };
    if (Result<void> done =
            addStrandDraws((*strands)[0], baseline::sampleFragmentsVariant({}), offer, lists[1]);
        !done)
      return done.error();
    const auto behind = scene_.render(lists, view, pelage::BufferId::kInvalid, nullptr);
    if (!behind) return behind.error();

    const auto countBytes = scene_.device().read(counts_);
    if (!countBytes) return countBytes.error();
    uint32_t counts[2] = {0, 0};
    std::memcpy(counts, countBytes->data(), sizeof(counts));
    if (counts[1] > limit_) {
      constants.sampleRowStep = constants.sampleRowStep * (counts[1] / limit_ + 1);
      if (constants.sampleRowStep < view.height) continue;
      return pelage::Error{pelage::ErrorCode::kInvalidArgument,
                           "a row has more fragments than the reference has room for"};
    }
    std::vector<SampledFragment> fragments(counts[1]);
    if (!fragments.empty()) {
      const auto bytes =
          scene_.device().read(fragments_, 0, fragments.size() * sizeof(SampledFragment));
      if (!bytes) return bytes.error();
      std::memcpy(fragments.data(), bytes->data(), bytes->size());
    }
    ExactPicture exact = composite(fragments, *behind);
    exact.fragments = counts[0];
    exact.rowStep = constants.sampleRowStep;
    return exact;
  }
}

PictureError comparePicture(const RenderedImage& image, const ExactPicture& exact) {
  PictureError error;
  if (exact.pixels.empty()) return error;
  double sum = 0;
  uint64_t off = 0;
  for (const ExactPicture::Pixel& pixel : exact.pixels) {
    const Float4& seen = image.pixels[pixel.index];
    const float channels[3] = {seen.x, seen.y, seen.z};
    double largest = 0;
    for (int c = 0; c < 3; ++c) {
      const double difference = static_cast<double>(channels[c]) - pixel.color[c];
      sum += difference * difference;
      // The comparison is false for NaN, which must not hide in a maximum.
      if (!(std::abs(difference) <= largest)) largest = std::abs(difference);
    }
    if (!(largest <= error.largest)) error.largest = largest;
    off += largest <= 1.0 / 255 ? 0 : 1;
  }
  const auto count = static_cast<double>(exact.pixels.size());
  if (sum != 0) error.psnr = -10 * std::log10(sum / (3 * count));
  error.off = static_cast<double>(off) / count;
  return error;
}

}  // namespace bench
