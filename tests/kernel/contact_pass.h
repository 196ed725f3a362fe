// find_contacts before the pass of a solver, on buffers of a test's own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "contact/hair_contacts.h"
#include "pelage/hair_object.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

/// What strands collide with, and the records of their contacts.
class ContactPass {
 public:
  static constexpr size_t kMaxCapsules = 4;

  /// \param strands in the order in which the solver takes them
  ContactPass(Gpu& gpu, const std::vector<ContactStrand>& strands, uint32_t verticesPerStrand,
              uint64_t vertices, uint32_t steps = 1)
      : gpu_(gpu), capsules_(gpu, "capsules", std::vector<Collider>(kMaxCapsules)) {
    contacts_.prepare(gpu.resources, "test", strands, verticesPerStrand, vertices, steps);
    expectOk(gpu.device()->update(gpu.resources));
  }
  ~ContactPass() {
    for (BufferId* buffer : contacts_.buffers()) {
      gpu_.hazards.forget(*buffer);
      gpu_.resources.remove(*buffer);
    }
  }
  ContactPass(const ContactPass&) = delete;
  ContactPass& operator=(const ContactPass&) = delete;

  void setCapsules(PassList& list, std::vector<Collider> capsules) {
    ASSERT_LE(capsules.size(), kMaxCapsules);
    capsuleCount_ = static_cast<uint32_t>(capsules.size());
    capsules.resize(kMaxCapsules);
    capsules_.upload(list, capsules);
  }
  /// Keys and surface stay as they are after the first time.
  void setFields(PassList& list, const std::vector<SdfField>& fields,
                 const std::vector<uint32_t>& keys, const std::vector<Uint4>& surface) {
    if (fields_) {
      fields_->upload(list, fields);
      return;
    }
    fieldCount_ = static_cast<uint32_t>(fields.size());
    fields_.emplace(gpu_, "fields", fields);
    keys_.emplace(gpu_, "fieldKeys", keys);
    surface_.emplace(gpu_, "fieldSurface", surface);
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
        .fields = fields_ ? fields_->id() : BufferId::kInvalid,
        .fieldCount = fieldCount_,
        .fieldKeys = keys_ ? keys_->id() : BufferId::kInvalid,
        .fieldSurface = surface_ ? surface_->id() : BufferId::kInvalid};
    expectOk(contacts_.find(list, gpu_.resources, hair, colliders, {.buffer = hair.roots}, step));
  }
  /// Offers the records to a solver.
  void bindTo(PassBuilder& builder) const {
    builder.bind("g_contacts", contacts_.records(), contacts_.recordBytes())
        .bind("g_contactWords", contacts_.words(), contacts_.wordBytes());
  }
  const detail::HairContacts& contacts() const { return contacts_; }
  /// Of the last frame.
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
  Gpu& gpu_;
  detail::HairContacts contacts_;
  uint32_t capsuleCount_ = 0, fieldCount_ = 0;
  GuardedBuffer<Collider> capsules_;
  std::optional<GuardedBuffer<SdfField>> fields_;
  std::optional<GuardedBuffer<uint32_t>> keys_;
  std::optional<GuardedBuffer<Uint4>> surface_;
};

}  // namespace pelage::test
