// Lines of a glTF 2.0 file. Khronos, "glTF 2.0 Specification": 3.5.3 (transformations), 3.7.2
// (primitives). Not by assimp, which splits strips into segments and drops what is out of range
// without a word.
#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "common/errors.h"
#include "gltf_file.h"
#include "line_chains.h"
#include "pelage/authoring/hair_files.h"

namespace pelage {
namespace {

using Eigen::Matrix4d;
using nlohmann::json;

constexpr uint64_t kLines = 1, kLineLoop = 2, kLineStrip = 3, kTriangles = 4;
// Vertices that small files may make of instances of a mesh.
constexpr uint64_t kFreeVertices = 65536;
// Work that a file may cause, in vertices and primitives.
constexpr uint64_t kStepsPerByte = 64;

class GltfReader {
 public:
  GltfReader(std::span<const std::byte> bytes, std::string_view name,
             const std::filesystem::path& folder, HairFileReport& report)
      : file_(bytes, name, folder), report_(report) {}

  Result<HairCurves> read() {
    if (auto r = file_.parse(); !r) return r.error();
    if (auto r = startScene(); !r) return r.error();
    while (!stack_.empty())
      if (auto r = visitNode(); !r) return r.error();
    if (curves_.vertexCounts.empty())
      return file_.fail("meshes", fmt::format("no lines in the scene ({} other primitives); export "
                                              "the hair as curves or edges",
                                              otherCount_));
    if (otherCount_ > 0)
      report_.notes.push_back(
          fmt::format("{} primitives that are no lines are ignored", otherCount_));
    if (joinedCount_ > 0)
      report_.notes.push_back(fmt::format("{} lines of two vertices were joined to {} curves",
                                          joinedCount_, chainCount_));
    if (!anyColor_) curves_.colors.clear();
    if (!anyUv_) curves_.vertexUv.clear();
    return std::move(curves_);
  }

 private:
  struct Visit {
    uint64_t node;
    Matrix4d toParent;
  };

  Result<void> pushNodes(const json& object, const char* member, const std::string& path,
                         const Matrix4d& toParent) {
    const auto list = object.find(member);
    if (list == object.end()) return {};
    if (!list->is_array()) return file_.fail(path, fmt::format("'{}' is not an array", member));
    for (size_t i = list->size(); i-- > 0;) {
      if (!(*list)[i].is_number_unsigned())
        return file_.fail(path, fmt::format("{}[{}] is not the number of a node", member, i));
      stack_.push_back({(*list)[i].get<uint64_t>(), toParent});
    }
    return {};
  }

  Result<void> startScene() {
    const auto nodes = file_.root().find("nodes");
    visited_.resize(nodes != file_.root().end() && nodes->is_array() ? nodes->size() : 0);
    auto scene = file_.whole(file_.root(), "scene", "scene", 0);
    if (!scene) return scene.error();
    auto object = file_.element("scenes", *scene);
    if (!object) return object.error();
    return pushNodes(**object, "nodes", fmt::format("scenes[{}]", *scene), Matrix4d::Identity());
  }

  // Without recursion: a file can nest its nodes as deeply as it likes.
  Result<void> visitNode() {
    const Visit visit = stack_.back();
    stack_.pop_back();
    const std::string path = fmt::format("nodes[{}]", visit.node);
    auto node = file_.element("nodes", visit.node);
    if (!node) return node.error();
    if (visited_[visit.node]) return file_.fail(path, "it is in the scene twice; nodes are a tree");
    visited_[visit.node] = true;
    auto local = transformOf(**node, path);
    if (!local) return local.error();
    const Matrix4d toScene = visit.toParent * *local;
    if (auto r = pushNodes(**node, "children", path, toScene); !r) return r;
    if (!(*node)->contains("mesh")) return {};
    auto mesh = file_.whole(**node, "mesh", path);
    if (!mesh) return mesh.error();
    return readMesh(*mesh, toScene);
  }

  // `count` numbers of a member into `out`; false when it is missing.
  Result<bool> numbers(const json& object, const char* member, const std::string& path,
                       size_t count, double* out) {
    const auto found = object.find(member);
    if (found == object.end()) return false;
    bool good = found->is_array() && found->size() == count;
    for (size_t i = 0; good && i < count; ++i) {
      good = (*found)[i].is_number();
      if (good) out[i] = (*found)[i].get<double>();
    }
    if (!good) return file_.fail(path + "." + member, fmt::format("not {} numbers", count));
    return true;
  }

  Result<Matrix4d> transformOf(const json& node, const std::string& path) {
    Matrix4d matrix = Matrix4d::Identity();  // column by column, as in the file
    auto whole = numbers(node, "matrix", path, 16, matrix.data());
    if (!whole) return whole.error();
    if (*whole) return matrix;
    Eigen::Vector3d move = Eigen::Vector3d::Zero(), scale = Eigen::Vector3d::Ones();
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // x y z w in memory, too
    if (auto r = numbers(node, "translation", path, 3, move.data()); !r) return r.error();
    if (auto r = numbers(node, "scale", path, 3, scale.data()); !r) return r.error();
    if (auto r = numbers(node, "rotation", path, 4, turn.coeffs().data()); !r) return r.error();
    if (!(turn.norm() > 0)) return file_.fail(path + ".rotation", "a quaternion of length 0");
    matrix.topLeftCorner<3, 3>() = turn.normalized().toRotationMatrix() * scale.asDiagonal();
    matrix.topRightCorner<3, 1>() = move;
    return matrix;
  }

  Result<void> readMesh(uint64_t index, const Matrix4d& toScene) {
    const std::string path = fmt::format("meshes[{}]", index);
    auto mesh = file_.element("meshes", index);
    if (!mesh) return mesh.error();
    const auto primitives = (*mesh)->find("primitives");
    if (primitives == (*mesh)->end() || !primitives->is_array())
      return file_.fail(path, "no 'primitives'");
    for (size_t i = 0; i < primitives->size(); ++i)
      if (auto r =
              readPrimitive((*primitives)[i], fmt::format("{}.primitives[{}]", path, i), toScene);
          !r)
        return r;
    return {};
  }

  Result<void> readPrimitive(const json& primitive, const std::string& path,
                             const Matrix4d& toScene) {
    if (!primitive.is_object()) return file_.fail(path, "not an object");
    auto mode = file_.whole(primitive, "mode", path, kTriangles);
    if (!mode) return mode.error();
    if (auto r = spend(1, path); !r) return r;
    if (*mode < kLines || *mode > kLineStrip) {
      ++otherCount_;
      return {};
    }
    if (auto r = readVertices(primitive, path); !r) return r;
    std::vector<uint32_t> order;
    if (primitive.contains("indices")) {
      auto accessor = file_.whole(primitive, "indices", path);
      if (!accessor) return accessor.error();
      auto indices = file_.indices(*accessor);
      if (!indices) return indices.error();
      order = *std::move(indices);
      if (auto r = spend(order.size(), path); !r) return r;
      for (size_t i = 0; i < order.size(); ++i)
        if (order[i] >= vertices_.size())
          return file_.fail(path, fmt::format("index {} is {}, but there are {} vertices", i,
                                              order[i], vertices_.size()));
    } else {
      if (auto r = spend(vertices_.size(), path); !r) return r;
      for (size_t i = 0; i < vertices_.size(); ++i) order.push_back(static_cast<uint32_t>(i));
    }
    if (*mode != kLines) {
      if (*mode == kLineLoop) order.push_back(order.front());
      return addCurve(order, path, toScene);
    }
    // By their places among the vertices in use: the array may be that of all strands.
    std::vector<uint32_t> used = order;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto indexOf = [&](uint32_t vertex) {
      return static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), vertex) -
                                   used.begin());
    };
    std::vector<std::pair<uint32_t, uint32_t>> segments;
    for (size_t i = 0; i + 1 < order.size(); i += 2)
      segments.push_back({indexOf(order[i]), indexOf(order[i + 1])});
    detail::LineChains chains = detail::joinSegments(segments, static_cast<uint32_t>(used.size()));
    for (uint32_t& vertex : chains.vertices) vertex = used[vertex];
    joinedCount_ += segments.size();
    chainCount_ += chains.counts.size();
    size_t begin = 0;
    for (const uint32_t count : chains.counts) {
      const std::span<const uint32_t> chain = std::span(chains.vertices).subspan(begin, count);
      if (auto r = addCurve(chain, path, toScene); !r) return r;
      begin += count;
    }
    return {};
  }

  // The attributes of a primitive.
  Result<void> readVertices(const json& primitive, const std::string& path) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object())
      return file_.fail(path, "no 'attributes'");
    // Some exporters put all strands into one array, and the primitives differ in their indices.
    if (*attributes == attributes_) return {};
    attributes_ = *attributes;
    auto positions = attribute(*attributes, "POSITION", path, 3, 3);
    if (!positions) return positions.error();
    if (positions->empty()) return file_.fail(path, "no POSITION");
    auto colors = attribute(*attributes, "COLOR_0", path, 3, 4);
    if (!colors) return colors.error();
    auto uv = attribute(*attributes, "TEXCOORD_0", path, 2, 2);
    if (!uv) return uv.error();
    const size_t count = positions->size() / 3;
    if (auto r = spend(count, path); !r) return r;
    const size_t components = colors->size() / count;
    if (colors->size() % count != 0 || (!colors->empty() && components != 3 && components != 4) ||
        (!uv->empty() && uv->size() != count * 2))
      return file_.fail(path, fmt::format("its attributes do not all have {} vertices", count));
    vertices_.assign(count, {});
    for (size_t i = 0; i < count; ++i) {
      Vertex& vertex = vertices_[i];
      vertex.position = {(*positions)[i * 3], (*positions)[i * 3 + 1], (*positions)[i * 3 + 2]};
      if (!uv->empty()) vertex.uv = {(*uv)[i * 2], (*uv)[i * 2 + 1]};
      if (colors->empty()) continue;
      const float* c = colors->data() + i * components;
      vertex.color = {c[0], c[1], c[2], components == 4 ? c[3] : 1};
    }
    anyColor_ = anyColor_ || !colors->empty();
    anyUv_ = anyUv_ || !uv->empty();
    return {};
  }

  // Empty when it is missing.
  Result<std::vector<float>> attribute(const json& attributes, const char* name,
                                       const std::string& path, uint32_t fewest, uint32_t most) {
    if (!attributes.contains(name)) return std::vector<float>();
    auto accessor = file_.whole(attributes, name, path + ".attributes");
    if (!accessor) return accessor.error();
    auto components = file_.componentCount(*accessor);
    if (!components) return components.error();
    if (*components < fewest || *components > most)
      return file_.fail(fmt::format("accessors[{}].type", *accessor),
                        fmt::format("not one for {}", name));
    return file_.floats(*accessor, *components);
  }

  // A small file can name the same data again and again.
  Result<void> spend(uint64_t steps, const std::string& path) {
    steps_ += steps;
    if (steps_ <= kStepsPerByte * (kFreeVertices + file_.bytesRead())) return {};
    return file_.fail(path,
                      "the file repeats the same meshes too often; apply instances, and give "
                      "each mesh its own vertices");
  }

  Result<void> addCurve(std::span<const uint32_t> order, const std::string& path,
                        const Matrix4d& toScene) {
    const uint64_t limit = kFreeVertices + file_.bytesRead();
    if (order.size() > limit - std::min<uint64_t>(limit, curves_.positions.size()))
      return file_.fail(path, fmt::format("instances of meshes make more than {} vertices of {} "
                                          "bytes; apply them before exporting",
                                          limit, file_.bytesRead()));
    for (const uint32_t index : order) {
      const Vertex& vertex = vertices_[index];
      const Eigen::Vector4d p(vertex.position.x, vertex.position.y, vertex.position.z, 1);
      const Eigen::Vector4d moved = toScene * p;
      curves_.positions.push_back({static_cast<float>(moved.x()), static_cast<float>(moved.y()),
                                   static_cast<float>(moved.z())});
      curves_.colors.push_back(vertex.color);
      curves_.vertexUv.push_back(vertex.uv);
    }
    curves_.vertexCounts.push_back(static_cast<uint32_t>(order.size()));
    return {};
  }

  struct Vertex {
    Float3 position;
    Float4 color{1, 1, 1, 1};
    Float2 uv;
  };

  detail::GltfFile file_;
  HairFileReport& report_;
  std::vector<Visit> stack_;
  std::vector<bool> visited_;     // [node]
  std::vector<Vertex> vertices_;  // of the primitive
  json attributes_;               // that vertices_ come from
  uint64_t steps_ = 0, otherCount_ = 0, joinedCount_ = 0, chainCount_ = 0;
  bool anyColor_ = false, anyUv_ = false;
  HairCurves curves_;
};

}  // namespace

Result<HairCurves> loadGltfCurves(std::span<const std::byte> bytes, std::string_view name,
                                  const std::filesystem::path& folder, HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    HairFileReport found{HairFileKind::kGltf, "glTF 2.0 lines", bytes.size(), {}};
    auto curves = GltfReader(bytes, name, folder, found).read();
    if (report != nullptr) *report = std::move(found);
    return curves;
  });
}

}  // namespace pelage
