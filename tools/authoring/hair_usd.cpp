// BasisCurves of .usda files. OpenUSD: UsdGeomBasisCurves (segments, wraps, sizes of primvars),
// UsdGeomXformable (order of operations), UsdGeomImageable (visibility). Names that begin with
// groom_: Epic Games, "Alembic for Grooms Specification".
#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "axes.h"
#include "common/errors.h"
#include "pelage/authoring/hair_files.h"
#include "points.h"
#include "text_lines.h"
#include "usda_layer.h"

namespace pelage {
namespace {

using detail::UsdaAttribute;
using detail::UsdaLayer;
using detail::UsdaPrim;
using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr std::string_view kPrimvars = "primvars:", kIndices = ":indices";
// A curve of cubic segments becomes a polyline that is off by a thousandth of its length at most,
// if so many pieces of a segment are enough.
constexpr double kRelativeError = 1e-3;
constexpr double kMaxPieces = 16;
constexpr double kDefaultMetersPerUnit = 0.01;  // UsdGeomLinearUnits

// Primvars by their use; the first one that a prim has counts.
constexpr std::string_view kWidthNames[] = {"groom_width", "widths"};
constexpr std::string_view kColorNames[] = {"groom_color", "displayColor"};
constexpr std::string_view kOpacityNames[] = {"displayOpacity"};
constexpr std::string_view kRootUvNames[] = {"groom_root_uv", "surface_uv_coordinate"};
constexpr std::string_view kUvNames[] = {"st", "uv", "UVMap"};
constexpr std::string_view kMassNames[] = {"pelage:inverseMass"};
constexpr std::string_view kIdNames[] = {"groom_id", "id"};
constexpr std::string_view kGuideNames[] = {"groom_guide"};
constexpr std::string_view kGroupNames[] = {"groom_group_id"};

bool isPrimvar(std::string_view name) {
  for (const std::span<const std::string_view> names :
       {std::span<const std::string_view>(kWidthNames),
        std::span<const std::string_view>(kColorNames),
        std::span<const std::string_view>(kOpacityNames),
        std::span<const std::string_view>(kRootUvNames),
        std::span<const std::string_view>(kUvNames), std::span<const std::string_view>(kMassNames),
        std::span<const std::string_view>(kIdNames), std::span<const std::string_view>(kGuideNames),
        std::span<const std::string_view>(kGroupNames)})
    if (std::find(names.begin(), names.end(), name) != names.end()) return true;
  return false;
}

enum class Basis { kLinear, kBezier, kBspline, kCatmullRom };
enum class Wrap { kNonperiodic, kPeriodic, kPinned };

// Weights of the four vertices of a segment at t; of the second derivative with `bends`.
std::array<double, 4> weightsOf(Basis basis, double t, bool bends) {
  const double s = 1 - t;
  if (basis == Basis::kBezier) {
    if (bends) return {6 * s, 6 * (3 * t - 2), 6 * (1 - 3 * t), 6 * t};
    return {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
  }
  if (basis == Basis::kBspline) {
    if (bends) return {s, 3 * t - 2, 1 - 3 * t, t};
    return {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6,
            (1 + 3 * t + 3 * t * t - 3 * t * t * t) / 6, t * t * t / 6};
  }
  if (bends) return {2 - 3 * t, 9 * t - 5, 4 - 9 * t, 3 * t - 1};
  return {(-t + 2 * t * t - t * t * t) / 2, (2 - 5 * t * t + 3 * t * t * t) / 2,
          (t + 4 * t * t - 3 * t * t * t) / 2, (t * t * t - t * t) / 2};
}

// How the vertices of one curve become segments.
struct Topology {
  Basis basis = Basis::kBezier;
  Wrap wrap = Wrap::kNonperiodic;

  int64_t step() const { return basis == Basis::kBezier ? 3 : 1; }
  bool isPinned() const { return wrap == Wrap::kPinned && basis != Basis::kBezier; }
  bool isPeriodic() const { return wrap == Wrap::kPeriodic; }
  /// Whether a curve of `n` vertices has no cubic segment: its vertices are a polyline.
  bool isPolyline(int64_t n) const {
    if (basis == Basis::kLinear) return true;
    return n < (isPinned() ? 2 : isPeriodic() ? 3 : 4);
  }
  /// Whether `n` vertices are not a whole number of segments.
  bool hasRest(int64_t n) const {
    if (isPolyline(n) || isPinned()) return false;
    return (isPeriodic() ? n : n - 4) % step() != 0;
  }
  int64_t segments(int64_t n) const {
    if (isPolyline(n)) return isPeriodic() && n > 2 ? n : std::max<int64_t>(n - 1, 0);
    if (isPinned()) return n - 1;
    return isPeriodic() ? n / step() : (n - 4) / step() + 1;
  }
  /// Varying values of the curve.
  int64_t varyings(int64_t n) const {
    if (isPolyline(n)) return n;
    return segments(n) + (isPeriodic() ? 0 : 1);
  }
  /// The vertex before a pinned or closed curve's first segment is that before vertex 0.
  int64_t firstVertex(int64_t segment) const {
    return segment * step() - (isPinned() || (isPeriodic() && basis != Basis::kBezier) ? 1 : 0);
  }
};

// A vertex of the polyline: on a segment, at t. A polyline's segment s begins at its vertex s.
struct Sample {
  int64_t segment;
  double t;
};

/// Values with some components each, from the elements of an attribute.
struct Values {
  enum class Per { kPrim, kCurve, kVertex, kVarying };
  Per per = Per::kPrim;
  uint32_t components = 0;  ///< 0: there are none
  std::vector<float> numbers;

  bool exist() const { return components > 0; }
};

class UsdReader {
 public:
  UsdReader(std::span<const std::byte> bytes, std::string_view name, HairFileReport& report)
      : bytes_(bytes), name_(name), report_(report) {}

  Result<HairCurves> read() {
    auto layer = detail::readUsda(bytes_, name_,
                                  [this](auto type, auto name) { return isWanted(type, name); });
    if (!layer) return layer.error();
    layer_ = *std::move(layer);
    if (auto r = readUnits(); !r) return r.error();
    states_.resize(layer_.prims.size());
    for (uint32_t prim = 0; prim < layer_.prims.size(); ++prim)
      if (auto r = visit(prim); !r) return r.error();
    if (curves_.vertexCounts.empty()) return noCurves();
    finish();
    return std::move(curves_);
  }

 private:
  struct State {
    bool known = false, visible = true;
    Matrix4d toWorld = Matrix4d::Identity();
  };

  bool isWanted(std::string_view primType, std::string_view name) {
    if (name.starts_with("xformOp") || name == "visibility") return true;
    if (name.starts_with(kPrimvars)) {
      name.remove_prefix(kPrimvars.size());
      if (name.ends_with(kIndices)) name.remove_suffix(kIndices.size());
      const bool known = isPrimvar(name);
      if (!known && name.starts_with("groom_") && notRead_.size() < kMaxNotes)
        notRead_.insert(std::string(detail::clip(name)));
      return known;
    }
    return primType == "BasisCurves" &&
           (name == "points" || name == "curveVertexCounts" || name == "type" || name == "basis" ||
            name == "wrap" || name == "widths");
  }

  Error fail(uint32_t prim, std::string_view what, uint64_t line = 0) const {
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}:{}: {}: {}", name_, line > 0 ? line : layer_.prims[prim].line,
                             layer_.pathOf(prim), what)};
  }

  Error noCurves() const {
    std::string what = "the file has no BasisCurves that are defined and visible";
    if (hiddenCount_ > 0) what += fmt::format("; {} are invisible or inactive", hiddenCount_);
    if (otherCurves_ > 0)
      what +=
          fmt::format("; {} prims are curves of another kind: export BasisCurves", otherCurves_);
    if (layer_.hasSublayers || composes_)
      what += "; other layers are not read: usdcat --flatten -o flat.usda FILE";
    return Error{ErrorCode::kInvalidFile, fmt::format("{}:1: {}", name_, what)};
  }

  Result<void> readUnits() {
    const auto failed = [&](std::string_view what) {
      return Error{ErrorCode::kInvalidFile, fmt::format("{}:1: {}", name_, what)};
    };
    const double unit = layer_.metersPerUnit.value_or(kDefaultMetersPerUnit);
    if (!(unit >= 1e-9 && unit <= 1e9))
      return failed(fmt::format("metersPerUnit is {}; it must be 1e-9 to 1e9", unit));
    const std::string_view up = layer_.upAxis.empty() ? "Y" : std::string_view(layer_.upAxis);
    if (up != "Y" && up != "Z")
      return failed(fmt::format("upAxis is '{}'; it must be Y or Z", detail::clip(up)));
    if (!layer_.metersPerUnit)
      report_.notes.push_back(
          "the file has no metersPerUnit: centimeters, the default of USD, are assumed");
    toMeters_.topLeftCorner<3, 3>() *= unit;
    if (up == "Z") {
      Matrix4d axes = Matrix4d::Zero();  // (x, y, z) -> (x, z, -y)
      axes(0, 0) = axes(1, 2) = axes(3, 3) = 1;
      axes(2, 1) = -1;
      toMeters_ = axes * toMeters_;
    }
    report_.format = fmt::format("USD curves, {:g} m per unit, {} up", unit, up == "Y" ? 'y' : 'z');
    return {};
  }

  Result<void> visit(uint32_t index) {
    const UsdaPrim& prim = layer_.prims[index];
    composes_ = composes_ || prim.composes;
    const bool isCurves = prim.type == "BasisCurves";
    if (prim.type == "NurbsCurves" || prim.type == "HermiteCurves") ++otherCurves_;
    if (!isCurves || !prim.defined) return {};
    if (auto r = evaluate(index); !r) return r;
    if (!prim.active || !states_[index].visible) {
      ++hiddenCount_;
      return {};
    }
    return readCurves(index);
  }

  // Transform and visibility of a prim and its parents.
  Result<void> evaluate(uint32_t index) {
    std::vector<uint32_t> chain;
    for (uint32_t at = index; at != UsdaPrim::kNoParent && !states_[at].known;
         at = layer_.prims[at].parent)
      chain.push_back(at);
    while (!chain.empty()) {
      const uint32_t at = chain.back();
      chain.pop_back();
      const UsdaPrim& prim = layer_.prims[at];
      State& state = states_[at];
      State parent;
      if (prim.parent != UsdaPrim::kNoParent) parent = states_[prim.parent];
      const UsdaAttribute* visibility = find(at, "visibility");
      state.visible = parent.visible && !(visibility != nullptr && !visibility->texts.empty() &&
                                          visibility->texts[0] == "invisible");
      bool resets = false;
      auto local = transformOf(at, resets);
      if (!local) return local.error();
      state.toWorld = resets ? *local : Matrix4d(parent.toWorld * *local);
      state.known = true;
    }
    return {};
  }

  /// Null if there is no value.
  const UsdaAttribute* find(uint32_t prim, std::string_view name) const {
    const auto& attributes = layer_.prims[prim].attributes;
    const auto found = attributes.find(name);
    return found != attributes.end() && found->second.hasValue() ? &found->second : nullptr;
  }

  Result<Matrix4d> transformOf(uint32_t prim, bool& resets) {
    Matrix4d matrix = Matrix4d::Identity();
    const UsdaAttribute* order = find(prim, "xformOpOrder");
    if (order == nullptr) return matrix;
    for (const std::string& entry : order->texts) {
      if (entry == "!resetXformStack!") {
        resets = true;
        matrix = Matrix4d::Identity();
        continue;
      }
      constexpr std::string_view kInvert = "!invert!";
      std::string_view name = entry;
      const bool inverts = name.starts_with(kInvert);
      if (inverts) name.remove_prefix(kInvert.size());
      const UsdaAttribute* op = find(prim, name);
      if (op == nullptr)
        return fail(prim,
                    fmt::format("xformOpOrder names '{}', which has no value", detail::clip(name)),
                    order->line);
      noteTime(*op);
      auto one = operation(prim, name, *op);
      if (!one) return one.error();
      if (inverts) {
        const Matrix4d inverse = one->inverse();
        if (!inverse.allFinite())
          return fail(prim, fmt::format("{} has no inverse", name), op->line);
        *one = inverse;
      }
      matrix = matrix * *one;
    }
    return matrix;
  }

  Result<Matrix4d> operation(uint32_t prim, std::string_view name, const UsdaAttribute& op) const {
    std::string_view kind = name;
    kind.remove_prefix(std::min(kind.size(), std::string_view("xformOp:").size()));
    kind = kind.substr(0, kind.find(':'));
    Matrix4d matrix = Matrix4d::Identity();
    const auto has = [&](uint32_t components) {
      return !op.isArray && op.components == components && op.texts.empty();
    };
    const auto vector = [&] { return Vector3d(op.number(0), op.number(1), op.number(2)); };
    const auto turn = [](int axis, double degrees) {
      return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector3d::Unit(axis))
          .toRotationMatrix();
    };
    if (kind == "translate" && has(3)) {
      matrix.topRightCorner<3, 1>() = vector();
    } else if (kind == "scale" && has(3)) {
      matrix.diagonal().head<3>() = vector();
    } else if (kind == "transform" && has(16)) {
      // Rows, for row vectors.
      for (int i = 0; i < 16; ++i) matrix(i % 4, i / 4) = op.number(static_cast<size_t>(i));
    } else if (kind == "orient" && has(4)) {
      const Eigen::Quaterniond q(op.number(0), op.number(1), op.number(2), op.number(3));
      if (!(q.norm() > 0)) return fail(prim, fmt::format("{} has no length", name), op.line);
      matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
    } else if (kind.size() == 7 && kind.starts_with("rotate") && kind[6] >= 'X' && kind[6] <= 'Z' &&
               has(1)) {
      matrix.topLeftCorner<3, 3>() = turn(kind[6] - 'X', op.number(0));
    } else if (kind.size() == 9 && kind.starts_with("rotate") && has(3)) {
      // rotateXYZ: about x first.
      for (const char axis : kind.substr(6)) {
        if (axis < 'X' || axis > 'Z')
          return fail(prim, fmt::format("'{}' is no operation of a transform", detail::clip(name)),
                      op.line);
        const int k = axis - 'X';
        matrix.topLeftCorner<3, 3>() =
            turn(k, op.number(static_cast<size_t>(k))) * matrix.topLeftCorner<3, 3>().eval();
      }
    } else {
      return fail(prim,
                  fmt::format("'{}' with the type {}{} is no operation of a transform",
                              detail::clip(name), detail::clip(op.type), op.isArray ? "[]" : ""),
                  op.line);
    }
    return matrix;
  }

  void noteTime(const UsdaAttribute& attribute) {
    if (attribute.time && !firstTime_) firstTime_ = attribute.time;
  }

  Result<std::string> token(uint32_t prim, std::string_view name, const char* fallback) const {
    const UsdaAttribute* found = find(prim, name);
    if (found == nullptr) return std::string(fallback);
    if (found->isArray || found->texts.empty())
      return fail(prim, fmt::format("{} is not a token", name), found->line);
    return found->texts[0];
  }

  Result<Topology> topologyOf(uint32_t prim) const {
    auto type = token(prim, "type", "cubic");
    if (!type) return type.error();
    auto basis = token(prim, "basis", "bezier");
    if (!basis) return basis.error();
    auto wrap = token(prim, "wrap", "nonperiodic");
    if (!wrap) return wrap.error();
    Topology result;
    if (*type == "linear") {
      result.basis = Basis::kLinear;
    } else if (*type != "cubic") {
      return fail(prim, fmt::format("type is '{}'; linear and cubic can be read", *type));
    } else if (*basis == "bspline") {
      result.basis = Basis::kBspline;
    } else if (*basis == "catmullRom") {
      result.basis = Basis::kCatmullRom;
    } else if (*basis != "bezier") {
      return fail(prim,
                  fmt::format("basis is '{}'; bezier, bspline and catmullRom can be read", *basis));
    }
    if (*wrap == "periodic")
      result.wrap = Wrap::kPeriodic;
    else if (*wrap == "pinned")
      result.wrap = Wrap::kPinned;
    else if (*wrap != "nonperiodic")
      return fail(prim,
                  fmt::format("wrap is '{}'; nonperiodic, periodic and pinned can be read", *wrap));
    return result;
  }

  // Sizes of the arrays of the prim at hand.
  struct Counts {
    std::vector<uint32_t> vertices;  // [curve]
    size_t vertexCount = 0, varyingCount = 0;
  };

  Result<Counts> countsOf(uint32_t prim, const Topology& topology, size_t pointCount) {
    const UsdaAttribute* found = find(prim, "curveVertexCounts");
    if (found == nullptr) return fail(prim, "curveVertexCounts has no value");
    noteTime(*found);
    if (found->numbers != UsdaAttribute::Numbers::kInteger || found->components != 1)
      return fail(prim, "curveVertexCounts is not an array of integers", found->line);
    Counts counts;
    for (const int64_t count : found->integers) {
      const size_t curve = counts.vertices.size();
      if (count < 0 || static_cast<uint64_t>(count) > pointCount - counts.vertexCount)
        return fail(prim,
                    fmt::format("curve {} has {} vertices, but {} of {} points are left", curve,
                                count, pointCount - counts.vertexCount, pointCount),
                    found->line);
      if (topology.hasRest(count))
        return fail(prim,
                    fmt::format("curve {} has {} vertices, which is no whole number of segments; "
                                "bezier curves have 4, 7, 10 or more (closed ones 3, 6, 9)",
                                curve, count),
                    found->line);
      if (topology.basis != Basis::kLinear && topology.isPolyline(count)) ++shortCount_;
      counts.vertices.push_back(static_cast<uint32_t>(count));
      counts.vertexCount += static_cast<size_t>(count);
      counts.varyingCount += static_cast<size_t>(topology.varyings(count));
    }
    if (counts.vertexCount != pointCount)
      return fail(prim,
                  fmt::format("there are {} points for the {} vertices of curveVertexCounts",
                              pointCount, counts.vertexCount),
                  found->line);
    return counts;
  }

  // Constant primvars also come from parents.
  const UsdaAttribute* findPrimvar(uint32_t prim, const std::string& name, uint32_t& owner) const {
    for (owner = prim; owner != UsdaPrim::kNoParent; owner = layer_.prims[owner].parent) {
      const UsdaAttribute* found = find(owner, name);
      if (found == nullptr) continue;
      const bool isConstant = found->interpolation.empty() || found->interpolation == "constant";
      if (owner == prim || isConstant) return found;
    }
    return nullptr;
  }

  Result<Values> primvar(uint32_t prim, std::span<const std::string_view> names,
                         uint32_t mostComponents, const Counts& counts) {
    for (const std::string_view name : names) {
      const std::string full = std::string(kPrimvars) + std::string(name);
      uint32_t owner = prim;
      const UsdaAttribute* found = findPrimvar(prim, full, owner);
      if (found != nullptr)
        return values(prim, full, *found, find(owner, full + std::string(kIndices)), mostComponents,
                      counts);
    }
    return Values();
  }

  Result<Values> values(uint32_t prim, std::string_view name, const UsdaAttribute& from,
                        const UsdaAttribute* indices, uint32_t mostComponents,
                        const Counts& counts) {
    noteTime(from);
    if (from.numbers == UsdaAttribute::Numbers::kText || from.components > 4)
      return fail(prim, fmt::format("{} has the type {}, which is no number", name, from.type),
                  from.line);
    Values result;
    result.components = std::min(from.components, mostComponents);
    const size_t elements = from.elementCount();
    const size_t size = indices != nullptr ? indices->integers.size() : elements;
    result.numbers.reserve(size * result.components);
    for (size_t i = 0; i < size; ++i) {
      const int64_t index = indices != nullptr ? indices->integers[i] : static_cast<int64_t>(i);
      if (index < 0 || static_cast<uint64_t>(index) >= elements)
        return fail(
            prim,
            fmt::format("index {} of {} is {}, but there are {} values", i, name, index, elements),
            indices->line);
      for (uint32_t k = 0; k < result.components; ++k)
        result.numbers.push_back(
            static_cast<float>(from.number(static_cast<size_t>(index) * from.components + k)));
    }
    auto per = interpolationOf(prim, name, from, size, counts);
    if (!per) return per.error();
    result.per = *per;
    return result;
  }

  // Where the file does not say, the number of values does.
  Result<Values::Per> interpolationOf(uint32_t prim, std::string_view name,
                                      const UsdaAttribute& from, size_t size,
                                      const Counts& counts) const {
    using Per = Values::Per;
    const std::pair<std::string_view, std::pair<Per, size_t>> all[] = {
        {"constant", {Per::kPrim, 1}},
        {"uniform", {Per::kCurve, counts.vertices.size()}},
        {"vertex", {Per::kVertex, counts.vertexCount}},
        {"varying", {Per::kVarying, counts.varyingCount}}};
    for (const auto& [interpolation, kind] : all) {
      if (!from.interpolation.empty() && from.interpolation != interpolation) continue;
      if (size == kind.second) return kind.first;
      if (from.interpolation.empty()) continue;
      return fail(prim,
                  fmt::format("{} has {} values; with the interpolation '{}' it needs {}", name,
                              size, interpolation, kind.second),
                  from.line);
    }
    if (!from.interpolation.empty())
      return fail(prim,
                  fmt::format("{}: the interpolation '{}' is none of curves", name,
                              detail::clip(from.interpolation)),
                  from.line);
    return fail(prim,
                fmt::format("{} has {} values; {} curves with {} vertices need 1, {}, {} or {}",
                            name, size, counts.vertices.size(), counts.vertexCount,
                            counts.vertices.size(), counts.vertexCount, counts.varyingCount),
                from.line);
  }

  // A curve of the prim: where its values begin.
  struct Curve {
    int64_t count = 0;
    size_t index = 0, vertex = 0, varying = 0;
  };

  // Component k of a value at a sample.
  static float valueAt(const Values& values, uint32_t k, const Topology& topology,
                       const Curve& curve, const Sample& sample) {
    const auto at = [&](size_t element) { return values.numbers[element * values.components + k]; };
    if (values.per == Values::Per::kPrim) return at(0);
    if (values.per == Values::Per::kCurve) return at(curve.index);
    if (topology.isPolyline(curve.count)) {
      const size_t first = values.per == Values::Per::kVertex ? curve.vertex : curve.varying;
      return at(first + static_cast<size_t>(sample.segment % curve.count));
    }
    if (values.per == Values::Per::kVarying) {
      const int64_t size = topology.varyings(curve.count);
      const auto a = static_cast<size_t>(sample.segment % size);
      const auto b = static_cast<size_t>((sample.segment + 1) % size);
      if (!(sample.t > 0)) return at(curve.varying + a);
      return static_cast<float>(double{at(curve.varying + a)} * (1 - sample.t) +
                                double{at(curve.varying + b)} * sample.t);
    }
    return static_cast<float>(
        blend(topology, curve, sample, false, [&](size_t vertex) { return double{at(vertex)}; }));
  }

  // The sum of the basis over the vertices of a segment. value(i): that of vertex i of the prim.
  template <class Value>
  static double blend(const Topology& topology, const Curve& curve, const Sample& sample,
                      bool bends, Value value) {
    const auto vertex = [&](int64_t i) { return value(curve.vertex + static_cast<size_t>(i)); };
    const auto control = [&](int64_t i) {
      const int64_t n = curve.count;
      if (topology.isPeriodic()) return vertex((i + n) % n);
      if (i < 0) return 2 * vertex(0) - vertex(1);
      if (i >= n) return 2 * vertex(n - 1) - vertex(n - 2);
      return vertex(i);
    };
    const std::array<double, 4> weights = weightsOf(topology.basis, sample.t, bends);
    const int64_t first = topology.firstVertex(sample.segment);
    double sum = 0;
    for (int64_t i = 0; i < 4; ++i)
      if (const double weight = weights[static_cast<size_t>(i)]; weight != 0)
        sum += weight * control(first + i);
    return sum;
  }

  void placeSamples(const Topology& topology, const Curve& curve, const Values& points,
                    std::vector<Sample>& samples) const {
    samples.clear();
    const int64_t segments = topology.segments(curve.count);
    if (topology.isPolyline(curve.count)) {
      for (int64_t i = 0; i < curve.count; ++i) samples.push_back({i, 0});
      if (segments == curve.count && curve.count > 0) samples.push_back({0, 0});
      return;
    }
    const auto coordinate = [&](uint32_t k) {
      return [&points, k](size_t vertex) { return double{points.numbers[vertex * 3 + k]}; };
    };
    double length = 0;
    for (int64_t i = 1; i < curve.count; ++i) {
      double square = 0;
      for (uint32_t k = 0; k < 3; ++k) {
        const auto vertex = curve.vertex + static_cast<size_t>(i);
        const double d = coordinate(k)(vertex) - coordinate(k)(vertex - 1);
        square += d * d;
      }
      length += std::sqrt(square);
    }
    for (int64_t s = 0; s < segments; ++s) {
      // The second derivative is linear: it is largest at an end. A chord over a share h of the
      // segment is off by h^2 / 8 of it.
      double largest = 0;
      for (const double t : {0.0, 1.0}) {
        double square = 0;
        for (uint32_t k = 0; k < 3; ++k) {
          const double bend = blend(topology, curve, {s, t}, true, coordinate(k));
          square += bend * bend;
        }
        largest = std::max(largest, std::sqrt(square));
      }
      const double wanted = std::ceil(std::sqrt(largest / (8 * kRelativeError * length)));
      const int pieces = wanted >= 1 ? static_cast<int>(std::min(wanted, kMaxPieces)) : 1;
      for (int i = 0; i < pieces; ++i) samples.push_back({s, static_cast<double>(i) / pieces});
    }
    samples.push_back({segments - 1, 1});
  }

  // The values of a prim.
  struct Arrays {
    Values points, widths, colors, opacities, masses, vertexUv, rootUv, ids, guides, groups;
  };

  Result<void> readCurves(uint32_t prim) {
    auto topology = topologyOf(prim);
    if (!topology) return topology.error();
    const UsdaAttribute* points = find(prim, "points");
    if (points == nullptr) return fail(prim, "points has no value");
    noteTime(*points);
    if (points->components != 3 || points->numbers == UsdaAttribute::Numbers::kInteger ||
        !points->isArray)
      return fail(prim, "points is not an array of points", points->line);
    auto counts = countsOf(prim, *topology, points->elementCount());
    if (!counts) return counts.error();
    Arrays arrays;
    arrays.points.per = Values::Per::kVertex;
    arrays.points.components = 3;
    arrays.points.numbers.reserve(counts->vertexCount * 3);
    for (size_t i = 0; i < counts->vertexCount * 3; ++i)
      arrays.points.numbers.push_back(static_cast<float>(points->number(i)));
    const std::pair<Values*, std::pair<std::span<const std::string_view>, uint32_t>> all[] = {
        {&arrays.widths, {kWidthNames, 1}},      {&arrays.colors, {kColorNames, 3}},
        {&arrays.opacities, {kOpacityNames, 1}}, {&arrays.masses, {kMassNames, 1}},
        {&arrays.vertexUv, {kUvNames, 2}},       {&arrays.rootUv, {kRootUvNames, 2}},
        {&arrays.guides, {kGuideNames, 1}},      {&arrays.groups, {kGroupNames, 1}}};
    for (const auto& [values, what] : all) {
      auto found = primvar(prim, what.first, what.second, *counts);
      if (!found) return found.error();
      if (found->exist() && found->components != what.second)
        return fail(prim, fmt::format("primvars:{} has {} numbers in a value; it needs {}",
                                      what.first.front(), found->components, what.second));
      *values = *std::move(found);
    }
    if (!arrays.widths.exist())
      if (const UsdaAttribute* widths = find(prim, "widths"); widths != nullptr) {
        auto found = values(prim, "widths", *widths, nullptr, 1, *counts);
        if (!found) return found.error();
        arrays.widths = *std::move(found);
      }
    // One value a curve: that of the root.
    if (arrays.vertexUv.per < Values::Per::kVertex && arrays.vertexUv.exist()) {
      if (!arrays.rootUv.exist()) arrays.rootUv = arrays.vertexUv;
      arrays.vertexUv = {};
    }
    auto ids = idsOf(prim, *counts);
    if (!ids) return ids.error();
    addCurves(prim, *topology, *counts, arrays, *ids);
    return {};
  }

  // Integers of 64 bits, which floats would round.
  Result<std::vector<uint64_t>> idsOf(uint32_t prim, const Counts& counts) {
    std::vector<uint64_t> ids;
    for (const std::string_view name : kIdNames) {
      const std::string full = std::string(kPrimvars) + std::string(name);
      const UsdaAttribute* found = find(prim, full);
      if (found == nullptr) continue;
      if (found->numbers != UsdaAttribute::Numbers::kInteger || found->components != 1)
        return fail(prim, fmt::format("{} is not an array of integers", full), found->line);
      const UsdaAttribute* indices = find(prim, full + std::string(kIndices));
      const size_t size = (indices != nullptr ? indices : found)->integers.size();
      if (size != counts.vertices.size())
        return fail(
            prim, fmt::format("{} has {} values for {} curves", full, size, counts.vertices.size()),
            found->line);
      for (size_t i = 0; i < size; ++i) {
        const int64_t at = indices != nullptr ? indices->integers[i] : static_cast<int64_t>(i);
        if (at < 0 || static_cast<uint64_t>(at) >= found->integers.size() ||
            found->integers[static_cast<size_t>(at)] < 0)
          return fail(prim, fmt::format("value {} of {} is no id of 0 or more", i, full),
                      found->line);
        ids.push_back(static_cast<uint64_t>(found->integers[static_cast<size_t>(at)]));
      }
      break;
    }
    return ids;
  }

  void addCurves(uint32_t prim, const Topology& topology, const Counts& counts,
                 const Arrays& arrays, std::span<const uint64_t> ids) {
    const Matrix4d toMeters = toMeters_ * states_[prim].toWorld;
    const bool moves = toMeters != Matrix4d::Identity();
    const double scale =
        moves ? std::cbrt(std::abs(toMeters.topLeftCorner<3, 3>().determinant())) : 1;
    const float factor = static_cast<float>(scale);
    const bool marks = !ids.empty() || arrays.guides.exist() || arrays.groups.exist();
    if (topology.basis == Basis::kBspline && topology.wrap == Wrap::kNonperiodic) ++looseCount_;
    std::vector<Sample> samples;
    Curve curve;
    for (const uint32_t count : counts.vertices) {
      curve.count = count;
      placeSamples(topology, curve, arrays.points, samples);
      const size_t first = curves_.positions.size(), end = first + samples.size();
      for (const Sample& sample : samples) {
        const auto at = [&](const Values& values, uint32_t k) {
          return valueAt(values, k, topology, curve, sample);
        };
        Float3 p = {at(arrays.points, 0), at(arrays.points, 1), at(arrays.points, 2)};
        if (moves) {
          const Eigen::Vector4d moved =
              toMeters * Eigen::Vector4d(double{p.x}, double{p.y}, double{p.z}, 1);
          p = detail::toFloat3({moved.x(), moved.y(), moved.z()});
        }
        curves_.positions.push_back(p);
        // Values that no prim had before are those of a prim without.
        if (arrays.widths.exist()) {
          curves_.radii.resize(curves_.positions.size() - 1, kUnitFiberRadius);
          curves_.radii.push_back(at(arrays.widths, 0) * 0.5f * factor);
        }
        if (arrays.masses.exist()) {
          curves_.inverseMasses.resize(curves_.positions.size() - 1, 1.0f);
          curves_.inverseMasses.push_back(at(arrays.masses, 0));
        }
        if (arrays.vertexUv.exist()) {
          curves_.vertexUv.resize(curves_.positions.size() - 1);
          curves_.vertexUv.push_back({at(arrays.vertexUv, 0), at(arrays.vertexUv, 1)});
        }
        if (arrays.colors.exist() || arrays.opacities.exist()) {
          Float4 color = {1, 1, 1, 1};
          curves_.colors.resize(curves_.positions.size() - 1, color);
          if (arrays.colors.exist())
            color = {at(arrays.colors, 0), at(arrays.colors, 1), at(arrays.colors, 2), 1};
          if (arrays.opacities.exist()) color.w = at(arrays.opacities, 0);
          curves_.colors.push_back(color);
        }
      }
      const Sample root = {0, 0};
      const bool hasRoot = count > 0;
      if (arrays.rootUv.exist() && hasRoot) {
        curves_.strandUv.resize(curves_.vertexCounts.size());
        curves_.strandUv.push_back({valueAt(arrays.rootUv, 0, topology, curve, root),
                                    valueAt(arrays.rootUv, 1, topology, curve, root)});
      }
      if (marks) {
        CurveLabel label = labelOf(curves_.vertexCounts.size());
        if (!ids.empty()) label.id = ids[curve.index];
        const auto whole = [&](const Values& values) {
          return values.exist() && hasRoot ? valueAt(values, 0, topology, curve, root) : 0;
        };
        label.isGuide = whole(arrays.guides) > 0;
        const float group = whole(arrays.groups);
        label.group = group >= 1 && group < 16777216 ? static_cast<uint32_t>(group) : 0;
        while (curves_.labels.size() < curves_.vertexCounts.size())
          curves_.labels.push_back(labelOf(curves_.labels.size()));
        curves_.labels.push_back(label);
      }
      curves_.vertexCounts.push_back(static_cast<uint32_t>(end - first));
      ++curve.index;
      curve.vertex += count;
      curve.varying += static_cast<size_t>(topology.varyings(curve.count));
    }
    ++primCount_;
  }

  static CurveLabel labelOf(size_t curve) { return {static_cast<uint64_t>(curve), 0, false}; }

  void finish() {
    const size_t vertices = curves_.positions.size(), count = curves_.vertexCounts.size();
    if (!curves_.radii.empty()) curves_.radii.resize(vertices, kUnitFiberRadius);
    if (!curves_.inverseMasses.empty()) curves_.inverseMasses.resize(vertices, 1.0f);
    if (!curves_.vertexUv.empty()) curves_.vertexUv.resize(vertices);
    if (!curves_.colors.empty()) curves_.colors.resize(vertices, {1, 1, 1, 1});
    if (!curves_.strandUv.empty()) curves_.strandUv.resize(count);
    if (!curves_.labels.empty())
      while (curves_.labels.size() < count)
        curves_.labels.push_back(labelOf(curves_.labels.size()));
    const auto note = [&](std::string text) { report_.notes.push_back(std::move(text)); };
    if (primCount_ > 1) report_.format += fmt::format(", {} prims", primCount_);
    if (firstTime_)
      note(fmt::format("time samples: the first ones, at {:g}, are read", *firstTime_));
    if (shortCount_ > 0)
      note(
          fmt::format("{} curves have too few vertices for a cubic segment; their vertices are "
                      "a polyline",
                      shortCount_));
    if (looseCount_ > 0)
      note(
          fmt::format("{} prims are B-splines that are not pinned: their curves do not begin at "
                      "the first vertex",
                      looseCount_));
    if (hiddenCount_ > 0)
      note(fmt::format("{} BasisCurves are invisible or inactive and were not read", hiddenCount_));
    if (otherCurves_ > 0)
      note(fmt::format("{} prims are NURBS or Hermite curves and were not read", otherCurves_));
    if (layer_.hasSublayers || composes_)
      note(
          "references, payloads, sublayers and variants are not read; usdcat --flatten has them "
          "in one file");
    std::string names;
    for (const std::string& name : notRead_) names += (names.empty() ? "" : ", ") + name;
    if (!names.empty()) note("primvars that were not read: " + names);
  }

  static constexpr size_t kMaxNotes = 16;

  std::span<const std::byte> bytes_;
  std::string_view name_;
  HairFileReport& report_;
  UsdaLayer layer_;
  Matrix4d toMeters_ = Matrix4d::Identity();
  std::vector<State> states_;      // [prim]
  std::set<std::string> notRead_;  // groom_ primvars
  std::optional<double> firstTime_;
  uint64_t primCount_ = 0, hiddenCount_ = 0, otherCurves_ = 0, shortCount_ = 0, looseCount_ = 0;
  bool composes_ = false;
  HairCurves curves_;
};

}  // namespace

Result<HairCurves> loadUsdCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    HairFileReport found{HairFileKind::kUsd, "USD curves", bytes.size(), {}};
    const std::string_view text = detail::asText(bytes);
    if (text.starts_with("PXR-USDC") || text.starts_with("PK\x03\x04"))
      return Error{
          ErrorCode::kInvalidFile,
          fmt::format("{}: byte 0: a binary USD file ({}); convert it to text with OpenUSD: "
                      "usdcat --flatten -o hair.usda {}",
                      name, text.front() == 'P' && text[1] == 'X' ? ".usdc" : ".usdz", name)};
    auto curves = UsdReader(bytes, name, found).read();
    if (report != nullptr) *report = std::move(found);
    return curves;
  });
}

}  // namespace pelage
