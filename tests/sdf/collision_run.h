// Vertices on the GPU that collide_vertices moves out of SDFs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sdf/sdf_collision.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

struct Vertices {
  std::vector<Float4> now, before;

  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double inverseMass = 1) {
    const auto float4 = [](const Eigen::Vector3d& v, double w) {
      return Float4{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
                    static_cast<float>(w)};
    };
    before.push_back(float4(from, 0));
    now.push_back(float4(to, inverseMass));
  }
  size_t size() const { return now.size(); }
};

class VertexBuffers {
 public:
  VertexBuffers(Gpu& gpu, const Vertices& vertices)
      : gpu_(gpu),
        positions_(gpu, "sdfPositions", vertices.now),
        before_(gpu, "sdfPositionsBefore", vertices.before) {}

  /// As many as there are.
  void set(const Vertices& vertices) {
    positions_.upload(list_, vertices.now);
    before_.upload(list_, vertices.before);
  }
  /// Where they are after a collision with the fields.
  Vertices collide(BufferId sdfs, BufferId keys, BufferId surface,
                   const detail::SdfCollisionDef& def) {
    expectOk(detail::addSdfCollision(list_, gpu_.resources,
                                     {positions_.id(), before_.id(), sdfs, keys, surface}, def));
    gpu_.execute(list_);
    return {positions_.read(), before_.read()};
  }

 private:
  Gpu& gpu_;
  PassList list_;
  GuardedBuffer<Float4> positions_, before_;
};

}  // namespace pelage::test
