// find_contacts before the pass of a solver, on buffers of a test's own.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "contact/hair_contacts.h"
#include "pelage/hair_object.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

/// Colliders of strands, and the records of their contacts.
class ContactPass {
 public:
  static constexpr size_t kMaxCapsules = 4;

  /// \param strands in the order in which the solver takes them
  ContactPass(Gpu& gpu, const detail::ContactStrands& strands, uint32_t verticesPerStrand,
              uint64_t vertices, uint32_t steps = 1)
      : gpu_(gpu), capsules_(gpu, "capsules", std::vector<Collider>(kMaxCapsules)) {
    contacts_.prepare(gpu.resources, "test", strands, verticesPerStrand, vertices, steps);
    expectOk(gpu.device()->update(gpu.resources));
  }
  ~ContactPass() { contacts_.remove({gpu_.resources, gpu_.hazards}); }
  ContactPass(const ContactPass&) = delete;
  ContactPass& operator=(const ContactPass&) = delete;

  void setCapsules(PassList& list, std::vector<Collider> capsules) {
    ASSERT_LE(capsules.size(), kMaxCapsules);
    capsuleCount_ = static_cast<uint32_t>(capsules.size());
    capsules.resize(kMaxCapsules);
    capsules_.upload(list, capsules);
    given_ = capsules;
    if (fields_) fields_->upload(list, withCapsules());
  }
  /// Keys and surface stay as they are after the first time.
  void setSdfs(PassList& list, const std::vector<Sdf>& sdfs, const std::vector<uint32_t>& keys,
               const std::vector<Uint4>& surface) {
    sdfs_ = sdfs;
    if (fields_) {
      fields_->upload(list, withCapsules());
      return;
    }
    sdfCount_ = static_cast<uint32_t>(sdfs.size());
    fields_.emplace(gpu_, "fields", withCapsules());
    keys_.emplace(gpu_, "contactSdfKeys", keys);
    surface_.emplace(gpu_, "contactSdfSurface", surface);
    expectOk(gpu_.device()->update(gpu_.resources));
  }

  /// Once before the first find() of a frame.
  void begin(PassList& list) { contacts_.begin(list); }
  /// The hair is where nothing led it.
  void forget() { contacts_.forget(); }
  void find(PassList& list, const detail::ContactHair& hair, const detail::ContactStep& step) {
    const detail::ColliderBuffers colliders = {
        .capsules = capsules_.id(),
        .capsuleCount = capsuleCount_,
        .sdfs = fields_ ? fields_->id() : BufferId::kInvalid,
        .contactSdfCount = sdfCount_,
        .contactSdfKeys = keys_ ? keys_->id() : BufferId::kInvalid,
        .contactSdfSurface = surface_ ? surface_->id() : BufferId::kInvalid};
    expectOk(
        contacts_.find(list, gpu_.resources, hair, colliders, {.buffer = hair.roots.buffer}, step));
  }
  /// Offers the records to a solver.
  void bindTo(PassBuilder& builder) const {
    builder.bind("g_contacts", contacts_.records(), contacts_.layout().recordBufferBytes())
        .bind("g_contactWords", contacts_.words(), contacts_.layout().wordBytes());
  }
  const detail::HairContacts& contacts() const { return contacts_; }
  /// Counters of the last frame.
  ContactCounters counters() const {
    Result<std::vector<std::byte>> words = gpu_.device()->read(contacts_.words());
    if (words) return readContactCounters(*words);
    ADD_FAILURE() << words.error().message;
    return {};
  }
  /// Fails when a pattern behind a buffer was written to.
  void checkGuards() const {
    (void)capsules_.read();
    if (!fields_) return;
    (void)fields_->read();
    (void)keys_->read();
    (void)surface_->read();
  }

 private:
  // As kernels with SDFs bind them.
  std::vector<Sdf> withCapsules() const {
    static_assert(sizeof(Sdf) == sizeof(Collider));
    std::vector<Sdf> all = sdfs_;
    all.resize(sdfs_.size() + kMaxCapsules);
    std::memcpy(static_cast<void*>(all.data() + sdfs_.size()), given_.data(),
                given_.size() * sizeof(Collider));
    return all;
  }

  Gpu& gpu_;
  detail::HairContacts contacts_;
  std::vector<Sdf> sdfs_;
  std::vector<Collider> given_;
  uint32_t capsuleCount_ = 0, sdfCount_ = 0;
  GuardedBuffer<Collider> capsules_;
  std::optional<GuardedBuffer<Sdf>> fields_;
  std::optional<GuardedBuffer<uint32_t>> keys_;
  std::optional<GuardedBuffer<Uint4>> surface_;
};

}  // namespace pelage::test
