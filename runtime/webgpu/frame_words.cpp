#include "frame_words.h"

#include <cstring>
#include <limits>
#include <string>

namespace pelage::webgpu {

namespace {

constexpr size_t kHeadWords = 5;
constexpr size_t kAlignment = 4;  // of bytes that words name

uint32_t stateOf(const DrawState& state) {
  return static_cast<uint32_t>(state.topology) + 8 * static_cast<uint32_t>(state.depthCompare) +
         (state.depthWrite ? 64 : 0) + 128 * static_cast<uint32_t>(state.blend) +
         (state.colorWrite ? 256 : 0);
}

}  // namespace

uint32_t FrameWriter::numberOf(BufferId id) const {
  const auto found = numbers_.find(id);
  return found == numbers_.end() ? 0 : found->second;
}

void FrameWriter::add(uint64_t word) {
  fits_ = fits_ && word <= std::numeric_limits<uint32_t>::max();
  words_.push_back(static_cast<uint32_t>(word));
}

// Offsets begin with 1 word, so that 0 is none.
uint32_t FrameWriter::put(std::span<const std::byte> bytes) {
  const size_t offset = bytes_.size();
  fits_ = fits_ && offset + bytes.size() <= std::numeric_limits<uint32_t>::max();
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  bytes_.resize((bytes_.size() + kAlignment - 1) / kAlignment * kAlignment);
  return static_cast<uint32_t>(offset);
}

void FrameWriter::addBuffers(const ResourceTable& resources) {
  uint32_t added = 0, removed = 0;
  std::vector<uint32_t> gone;
  for (auto entry = numbers_.begin(); entry != numbers_.end();) {
    if (resources.find(entry->first) != nullptr) {
      ++entry;
      continue;
    }
    gone.push_back(entry->second);
    ++removed;
    entry = numbers_.erase(entry);
  }
  for (uint32_t slot = 0; slot < resources.end(); ++slot) {
    const BufferId id = resources.at(slot);
    const BufferDesc* desc = resources.find(id);
    if (desc == nullptr || numbers_.contains(id)) continue;
    numbers_[id] = ++last_;
    ++added;
    const std::span<const std::byte> initial(desc->initial.data(), desc->initial.size());
    add(last_);
    add(desc->size);
    add(static_cast<uint32_t>(desc->usage));
    add(initial.empty() ? 0 : put(initial));
  }
  words_[2] = added;
  words_[3] = removed;
  words_.insert(words_.end(), gone.begin(), gone.end());
}

Result<void> FrameWriter::addPass(const PassList& list, const Pass& pass) {
  if (pass.specValueCount != 0) {
    return Error{ErrorCode::kUnsupported,
                 std::string("WebGPU: pass '") + pass.name + "' has specialization constants"};
  }
  const uint64_t kernel = pass.kernel->hash;
  const uint64_t pixel = pass.pixel != nullptr ? pass.pixel->hash : 0;
  add(static_cast<uint32_t>(pass.kind));
  for (const uint64_t hash : {kernel, pixel}) {
    add(hash & 0xffffffff);
    add(hash >> 32);
  }
  for (const uint32_t groups : pass.groups) add(groups);
  add(numberOf(pass.indirect));
  add(pass.indirectOffset);
  add(numberOf(pass.vertices.buffer));
  add(pass.vertices.offset);
  add(pass.vertices.size);
  add(numberOf(pass.indices));
  add(pass.elementCount);
  add(pass.instanceCount);
  add(stateOf(pass.state));
  add(pass.bindingCount);
  for (const PassBinding& binding : list.bindingsOf(pass)) {
    if (binding.texture != TextureId::kInvalid) {
      return Error{ErrorCode::kUnsupported, std::string("WebGPU: pass '") + pass.name +
                                                "' has a texture; it runs buffers alone"};
    }
    add(binding.set);
    add(binding.entry);
    add(numberOf(binding.buffer));
    add(binding.offset);
    add(binding.size);
  }
  return {};
}

Result<void> FrameWriter::addList(const PassList& list) {
  add(list.uploads.size());
  add(list.passes.size());
  add(put({list.constants.data(), list.constants.size()}));
  add(list.constants.size());
  for (const uint32_t edge : {list.area.x, list.area.y, list.area.width, list.area.height})
    add(edge);
  const uint32_t data = put({list.uploadData.data(), list.uploadData.size()});
  for (const Upload& upload : list.uploads) {
    add(numberOf(upload.buffer));
    add(upload.offset);
    add(data + upload.dataOffset);
    add(upload.size);
  }
  for (const Pass& pass : list.passes)
    if (Result<void> added = addPass(list, pass); !added) return added;
  return {};
}

Result<std::span<const std::byte>> FrameWriter::write(const ResourceTable& resources,
                                                      std::span<const PassList* const> lists) {
  const std::map<BufferId, uint32_t> before = numbers_;
  words_.assign(kHeadWords, 0);
  bytes_.assign(kAlignment, std::byte{});
  fits_ = true;
  addBuffers(resources);
  Result<void> added;
  for (size_t i = 0; i < lists.size() && added; ++i) added = addList(*lists[i]);
  if (added && !fits_)
    added = Error{ErrorCode::kInvalidArgument, "WebGPU: a frame has 4 GiB of data or more"};
  if (!added) {
    numbers_ = before;
    return added.error();
  }
  words_[0] = kFrameVersion;
  words_[1] = static_cast<uint32_t>(words_.size() * sizeof(uint32_t));
  words_[4] = static_cast<uint32_t>(lists.size());
  frame_.resize(words_[1] + bytes_.size());
  std::memcpy(frame_.data(), words_.data(), words_[1]);
  std::memcpy(frame_.data() + words_[1], bytes_.data(), bytes_.size());
  return std::span<const std::byte>(frame_.data(), frame_.size());
}

}  // namespace pelage::webgpu
