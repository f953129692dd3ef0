// SPDX-License-Identifier: MIT
/// @file
/// @brief The concept Tetrahedralizer: anything that turns a complex into a mesh.
///
/// A model is an object that can be copied and called, `Mesh operator()(const Plc&) const`; a lambda is a model. The
/// page docs/tetrahedralizers.md states the concept with its models; tet/axioms.hpp checks at run time what the
/// compiler cannot see.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"

#if defined(__cpp_concepts) && __cpp_concepts >= 201907L
#define SLICE2MESH_HAS_CONCEPTS 1
#else
/// 1 where the compiler has C++20 concepts, else 0.
#define SLICE2MESH_HAS_CONCEPTS 0
#endif

namespace slice2mesh {

/// What becomes of the facets of the complex.
enum class FacetKeeping : std::uint8_t {
  Exactly,     ///< every facet is a face of the mesh (on a bent wall, up to the choice of diagonals)
  Subdivided,  ///< every facet is a union of faces of the mesh
  No           ///< approximated or lost: elements may cross layers
};

/// The name in lower case.
[[nodiscard]] constexpr const char* to_string(FacetKeeping keeping) noexcept {
  switch (keeping) {
    case FacetKeeping::Exactly: return "exactly";
    case FacetKeeping::Subdivided: return "subdivided";
    case FacetKeeping::No: return "no";
  }
  return "unknown";
}

/// What a tetrahedralizer promises. The defaults promise nothing beyond the concept itself.
struct TetrahedralizerTraits {
  /// For reports.
  std::string name = "unnamed";
  /// What becomes of the facets.
  FacetKeeping facets = FacetKeeping::No;
  bool deterministic = false;         ///< the same complex gives the same mesh, bit by bit
  bool needs_conforming_plc = false;  ///< works only on a complex with inner faces and Gabriel contour edges
};

struct SlabFiller;

namespace detail {

template <class Model, class = void>
struct CanCall : std::false_type {};
template <class Model>
struct CanCall<Model, std::void_t<decltype(std::declval<Model&>()(std::declval<const Plc&>()))>> : std::true_type {};

template <class Model, class = void>
struct ResultOf {
  using type = void;
};
template <class Model>
struct ResultOf<Model, std::void_t<decltype(std::declval<const Model&>()(std::declval<const Plc&>()))>> {
  using type = decltype(std::declval<const Model&>()(std::declval<const Plc&>()));
};

/// The type of `traits()` of a model; void where there is none.
template <class Model, class = void>
struct TraitsOf {
  using type = void;
};
template <class Model>
struct TraitsOf<Model, std::void_t<decltype(std::declval<Model&>().traits())>> {
  using type = decltype(std::declval<Model&>().traits());
};

/// The type of the data member `progress` of a model; void where there is none.
template <class Model, class = void>
struct ProgressOf {
  using type = void;
};
template <class Model>
struct ProgressOf<Model, std::void_t<decltype(std::declval<Model&>().progress)>> {
  using type = decltype(std::declval<Model&>().progress);
};

template <class Model>
inline constexpr bool kIsObject = std::is_object_v<Model> && !std::is_const_v<Model> && !std::is_volatile_v<Model>;
template <class Model>
inline constexpr bool kIsCopyable = std::is_copy_constructible_v<Model>;
template <class Model>
inline constexpr bool kIsCallable = CanCall<Model>::value || CanCall<const Model>::value;
template <class Model>
inline constexpr bool kIsCallableConst = CanCall<const Model>::value;
template <class Model>
inline constexpr bool kGivesMesh = std::is_same_v<std::decay_t<typename ResultOf<Model>::type>, Mesh>;
template <class Model>
inline constexpr bool kTraitsFit =
    std::is_void_v<typename TraitsOf<Model>::type> ||
    std::is_same_v<std::decay_t<typename TraitsOf<const Model>::type>, TetrahedralizerTraits>;
template <class Model>
inline constexpr bool kHasProgress = std::is_same_v<typename ProgressOf<Model>::type, Progress>;
template <class Model>
inline constexpr bool kProgressFits = std::is_void_v<typename ProgressOf<Model>::type> || kHasProgress<Model>;

}  // namespace detail

/// True if `Model` meets every requirement of the concept.
template <class Model>
inline constexpr bool is_tetrahedralizer_v =
    detail::kIsObject<Model>&& detail::kIsCopyable<Model>&& detail::kIsCallableConst<Model>&&
        detail::kGivesMesh<Model>&& detail::kTraitsFit<Model>&& detail::kProgressFits<Model>;

#if SLICE2MESH_HAS_CONCEPTS
/// The same as a concept of C++20.
template <class Model>
concept Tetrahedralizer = is_tetrahedralizer_v<Model>;
#endif

/// Does not compile unless `Model` is a tetrahedralizer, and says which requirement it misses.
template <class Model>
constexpr void require_tetrahedralizer() {
  static_assert(detail::kIsObject<Model>,
                "slice2mesh: a Tetrahedralizer is an object type without const (not a reference, not void)");
  static_assert(detail::kIsCopyable<Model>, "slice2mesh: a Tetrahedralizer must be copyable");
  static_assert(detail::kIsCallable<Model>,
                "slice2mesh: a Tetrahedralizer must be callable with a complex: Mesh operator()(const Plc&) const");
  static_assert(!detail::kIsCallable<Model> || detail::kIsCallableConst<Model>,
                "slice2mesh: the call operator of a Tetrahedralizer must be const (a lambda must not be mutable)");
  static_assert(!detail::kIsCallableConst<Model> || detail::kGivesMesh<Model>,
                "slice2mesh: the call operator of a Tetrahedralizer must return a Mesh");
  static_assert(detail::kTraitsFit<Model>,
                "slice2mesh: traits() of a Tetrahedralizer must be const and return TetrahedralizerTraits");
  static_assert(detail::kProgressFits<Model>,
                "slice2mesh: the data member progress of a Tetrahedralizer must be a slice2mesh::Progress");
}

/// Where the traits of a model come from: its member `traits()` if it has one, else the defaults. Specialize it for a
/// type that cannot be changed.
template <class Model>
struct TraitsFor {
  /// The traits of a model.
  [[nodiscard]] static TetrahedralizerTraits of(const Model& model) {
    if constexpr (std::is_void_v<typename detail::TraitsOf<Model>::type>) {
      (void)model;
      return {};
    } else {
      return model.traits();
    }
  }
};

/// The traits of the slab filler.
template <>
struct TraitsFor<SlabFiller> {
  /// Keeps every facet, is deterministic, needs a conforming complex.
  [[nodiscard]] static TetrahedralizerTraits of(const SlabFiller&) {
    return {"slab", FacetKeeping::Exactly, true, true};
  }
};

/// The traits of a model.
template <class Model>
[[nodiscard]] TetrahedralizerTraits traits_of(const Model& model) {
  require_tetrahedralizer<Model>();
  return TraitsFor<Model>::of(model);
}

/// A model with other traits, see `with_traits`.
template <class Model>
class TraitedTetrahedralizer {
public:
  /// `model` with `traits` in place of its own.
  TraitedTetrahedralizer(Model model, TetrahedralizerTraits traits)
      : model_(std::move(model)), traits_(std::move(traits)) {}
  /// Calls the model. Errors: those of the model.
  [[nodiscard]] Mesh operator()(const Plc& plc) const { return model_(plc); }
  /// What the model promises.
  [[nodiscard]] const TetrahedralizerTraits& traits() const noexcept { return traits_; }

private:
  Model model_;
  TetrahedralizerTraits traits_;
};

/// A model that promises `traits`: the way to say what a lambda does.
template <class Model>
[[nodiscard]] TraitedTetrahedralizer<Model> with_traits(Model model, TetrahedralizerTraits traits) {
  require_tetrahedralizer<Model>();
  return {std::move(model), std::move(traits)};
}

/// Any tetrahedralizer, chosen at run time; itself a model. Copies share the model, which is never changed.
class AnyTetrahedralizer {
public:
  /// Not explicit: a function that takes a handle takes any model.
  template <class Model, class = std::enable_if_t<!std::is_same_v<std::decay_t<Model>, AnyTetrahedralizer>>>
  AnyTetrahedralizer(Model model) : held_(hold(std::move(model))) {}

  /// Calls the model. Errors: those of the model.
  [[nodiscard]] Mesh operator()(const Plc& plc) const { return held_->run(plc); }
  /// What the model promises.
  [[nodiscard]] TetrahedralizerTraits traits() const { return held_->traits(); }

  /// The model with `progress` as its listener, if it has a data member `progress` that nobody listens to yet;
  /// otherwise the model as it is.
  [[nodiscard]] AnyTetrahedralizer with_progress(const Progress& progress) const {
    return AnyTetrahedralizer(progress ? held_->with_progress(progress) : nullptr, held_);
  }

  /// A handle of a copy of the model, which shares nothing with this one.
  [[nodiscard]] AnyTetrahedralizer copy() const { return AnyTetrahedralizer(held_->copy(), held_); }

  /// The model, if it has this type; otherwise nullptr.
  template <class Model>
  [[nodiscard]] const Model* target() const noexcept {
    const auto* held = dynamic_cast<const Held<Model>*>(held_.get());
    return held == nullptr ? nullptr : std::addressof(held->model);
  }

private:
  struct Base {
    Base() = default;
    Base(const Base&) = delete;
    Base& operator=(const Base&) = delete;
    virtual ~Base() = default;
    [[nodiscard]] virtual Mesh run(const Plc& plc) const = 0;
    [[nodiscard]] virtual TetrahedralizerTraits traits() const = 0;
    [[nodiscard]] virtual std::shared_ptr<const Base> copy() const = 0;
    [[nodiscard]] virtual std::shared_ptr<const Base> with_progress(const Progress& progress) const = 0;
  };
  template <class Model>
  struct Held final : Base {
    explicit Held(Model m) : model(std::move(m)) {}
    [[nodiscard]] Mesh run(const Plc& plc) const override { return model(plc); }
    [[nodiscard]] TetrahedralizerTraits traits() const override { return traits_of(model); }
    [[nodiscard]] std::shared_ptr<const Base> copy() const override { return std::make_shared<Held>(model); }
    [[nodiscard]] std::shared_ptr<const Base> with_progress(const Progress& progress) const override {
      if constexpr (detail::kHasProgress<Model>) {
        if (model.progress) return nullptr;
        Model copy = model;
        copy.progress = progress;
        return std::make_shared<Held>(std::move(copy));
      } else {
        (void)progress;
        return nullptr;
      }
    }
    Model model;
  };

  AnyTetrahedralizer(std::shared_ptr<const Base> changed, std::shared_ptr<const Base> otherwise)
      : held_(changed ? std::move(changed) : std::move(otherwise)) {}

  template <class Model>
  [[nodiscard]] static std::shared_ptr<const Base> hold(Model model) {
    require_tetrahedralizer<Model>();
    // Without the branch a wrong model would be followed by errors from deep inside.
    if constexpr (is_tetrahedralizer_v<Model>) return std::make_shared<Held<Model>>(std::move(model));
  }

  std::shared_ptr<const Base> held_;
};

}  // namespace slice2mesh
