// The C interface of pelage, for engines in C, Rust, Zig, C# and others: docs/c.md. C99 and C++.
//
//     pelage_scene* scene;
//     pelage_id hair;
//     pelage_scene_create(&scene);
//     pelage_scene_add_hair(scene, asset, NULL, &hair);
//     ...
//     pelage_scene_simulate(scene, 1.0f / 60, &frame);
//     pelage_frame_draw(frame, &view, settings, NULL);
//     pelage_vulkan_record(runtime, frame, commands, &target, 1);
//     pelage_destroy(frame);
//
// Names, units, ranges and defaults are those of the C++ headers that the comments name.
//
// Handles: pointers to incomplete types stand for objects; they are no addresses. What a function
// makes lives until pelage_destroy(). A handle that is null, of another kind or destroyed is an
// error of every call.
//
// Structs: those with `struct_size` are filled with defaults by their init function, to which you
// give sizeof. A struct of another size than the library's is an error of init and of every call:
// header and library, or a binding and the header, do not fit. Pointers in structs and arguments
// are read during the call only, except where a comment says otherwise. Booleans are 0 or 1.
//
// Errors: functions return PELAGE_OK or the kind of the error, and pelage_last_error() has the
// message. After an error nothing has changed, and what the function would have made is NULL or 0;
// but a scene whose host runs out of memory in a call can only be destroyed.
//
// Threads: one thread at a time for a scene with its frames, and for a runtime or a device.
// Otherwise any thread, at any time: other scenes share nothing with it. Several may read an asset,
// a mesh or settings while none writes them.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "pelage/version.h"

// NOLINTBEGIN(readability-identifier-naming, modernize-*): C.

#if defined(_WIN32) && defined(pelage_c_EXPORTS)
#define PELAGE_C_API __declspec(dllexport)
#elif defined(__GNUC__)
#define PELAGE_C_API __attribute__((visibility("default")))
#else
#define PELAGE_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/// Kinds of errors: those of ErrorCode (result.h), each one more than there.
typedef enum pelage_result {
  PELAGE_OK = 0,
  PELAGE_ERROR_INVALID_ARGUMENT = 1,  ///< also a handle or a struct that is not valid
  PELAGE_ERROR_FILE_NOT_FOUND = 2,
  PELAGE_ERROR_INVALID_FILE = 3,
  PELAGE_ERROR_OUT_OF_MEMORY = 4,
  PELAGE_ERROR_UNSUPPORTED = 5,
  PELAGE_ERROR_DEVICE = 6,
  PELAGE_ERROR_DEVICE_LOST = 7
} pelage_result;

/// Returns PELAGE_VERSION of the library.
PELAGE_C_API uint32_t pelage_version(void);
/// Returns the message of the last call that failed on this thread, one line of UTF-8 that says
/// what to do; empty before one has. Valid until the next call that fails on this thread.
PELAGE_C_API const char* pelage_last_error(void);

typedef struct pelage_asset pelage_asset;        ///< hair of a file, with its bone weights
typedef struct pelage_mesh pelage_mesh;          ///< a CollisionMesh
typedef struct pelage_cache pelage_cache;        ///< an AssetCache: a .pelage file
typedef struct pelage_settings pelage_settings;  ///< SceneSettings, by the names of parameters
typedef struct pelage_scene pelage_scene;
typedef struct pelage_frame pelage_frame;
typedef struct pelage_snapshot pelage_snapshot;
typedef struct pelage_headless pelage_headless;  ///< a HeadlessDevice
typedef struct pelage_vulkan_runtime pelage_vulkan_runtime;
typedef struct pelage_gl_runtime pelage_gl_runtime;

/// A hair object, a mesh collider or a skeleton of a scene. 0 is none; ids are never reused.
typedef uint64_t pelage_id;
/// A buffer of a scene. 0 is none.
typedef uint64_t pelage_buffer_id;

/// Destroys the object of a handle of any kind; NULL is none. Objects of C++ that others still use
/// stay until these are gone: an asset whose hair is in a scene, say. A frame that has not run is
/// lost (docs/scene.md). Runtimes: their device has to have finished.
PELAGE_C_API pelage_result pelage_destroy(void* handle);

/// An AffineTransform: three rows of [M | t].
typedef struct pelage_transform {
  float rows[3][4];
} pelage_transform;

/// BoneInfluences: up to four bones of a root or a vertex.
typedef struct pelage_influences {
  uint32_t bones[4];
  float weights[4];
} pelage_influences;

// Assets (hair_asset.h, bone_weights.h, collision_mesh.h, asset_cache.h). Functions that load take
// the bytes of a file and a name for errors; with bytes NULL they read the file of that name.

typedef struct pelage_asset_def {
  uint32_t struct_size;
  uint32_t strand_count;
  uint32_t vertices_per_strand;
  const float* positions;         ///< [strand][vertex] x, y, z [m], inverse mass
  const uint32_t* vertex_counts;  ///< [strand]; NULL: all have vertices_per_strand
  const float* strand_uv;         ///< [strand] u, v; NULL for none
  const float* strand_thickness;  ///< [strand]; NULL for none
  const float* vertex_color;      ///< [strand][vertex] linear RGBA; NULL for none
} pelage_asset_def;
PELAGE_C_API pelage_result pelage_asset_def_init(pelage_asset_def* def, size_t size);

typedef struct pelage_asset_info {
  uint32_t struct_size;
  uint32_t strand_count;
  uint32_t vertices_per_strand;
  uint32_t bone_count;     ///< transforms that its influences need, at least 1
  const char* name;        ///< of hair in a cache, else empty; lives as long as the asset
  const float* positions;  ///< [strand][vertex] of 4 floats; as long as the asset
} pelage_asset_info;
PELAGE_C_API pelage_result pelage_asset_info_init(pelage_asset_info* info, size_t size);

/// Makes hair of arrays, which are copied, or loads a .tfx file; then HairAsset::process().
PELAGE_C_API pelage_result pelage_asset_create(const pelage_asset_def* def, pelage_asset** asset);
PELAGE_C_API pelage_result pelage_asset_load_tfx(const char* name, const void* bytes, size_t size,
                                                 pelage_asset** asset);
/// Hair on a head without a file: generateGroom() (demo/groom.h).
PELAGE_C_API pelage_result pelage_asset_generate(uint64_t seed, uint32_t strand_count,
                                                 pelage_asset** asset);
/// Loads the bone weights of the asset's strands: a .tfxbone file.
PELAGE_C_API pelage_result pelage_asset_load_bones(pelage_asset* asset, const char* name,
                                                   const void* bytes, size_t size);
/// Replaces the bones of the file by yours: mapBones(). \param names  [index] of your bones.
/// \param fallback  index for bones that you do not have; negative: such a bone is an error.
PELAGE_C_API pelage_result pelage_asset_map_bones(pelage_asset* asset, const char* const* names,
                                                  uint32_t count, int64_t fallback);
PELAGE_C_API pelage_result pelage_asset_get_info(pelage_asset* asset, pelage_asset_info* info);

/// A mesh of arrays, which are copied. \param positions  [vertex] x, y, z [m].
/// \param influences  [vertex]; NULL: all follow bone 0. \param indices  three a triangle.
PELAGE_C_API pelage_result pelage_mesh_create(const float* positions,
                                              const pelage_influences* influences,
                                              uint32_t vertex_count, const uint32_t* indices,
                                              uint32_t index_count, pelage_mesh** mesh);
PELAGE_C_API pelage_result pelage_mesh_load_tfxmesh(const char* name, const void* bytes,
                                                    size_t size, pelage_mesh** mesh);
/// As pelage_asset_map_bones().
PELAGE_C_API pelage_result pelage_mesh_map_bones(pelage_mesh* mesh, const char* const* names,
                                                 uint32_t count, int64_t fallback);

PELAGE_C_API pelage_result pelage_cache_load(const char* name, const void* bytes, size_t size,
                                             pelage_cache** cache);
PELAGE_C_API pelage_result pelage_cache_get_counts(pelage_cache* cache, uint32_t* hairs,
                                                   uint32_t* meshes);
/// Hair or a mesh of a cache, which may be destroyed behind it. Hair has its follow hairs.
PELAGE_C_API pelage_result pelage_cache_hair(pelage_cache* cache, uint32_t index,
                                             pelage_asset** asset);
PELAGE_C_API pelage_result pelage_cache_mesh(pelage_cache* cache, uint32_t index,
                                             pelage_mesh** mesh);

// Settings (settings/scene_settings.h, settings_file.h): the table of docs/parameters.md, by names
// as docs/settings.md has them: "simulation.wind.velocity", "lights[0].color".

/// The defaults: those of C++, with one light.
PELAGE_C_API pelage_result pelage_settings_create(pelage_settings** settings);
/// Sets what a JSON text has, and nothing else. \param text  NULL: the file of this name.
PELAGE_C_API pelage_result pelage_settings_load(pelage_settings* settings, const char* name,
                                                const char* text);
/// Sets all to those of a preset: "long", "curly", "fur", "mohawk", "afro", "beard".
PELAGE_C_API pelage_result pelage_settings_load_preset(pelage_settings* settings, const char* name);
/// Writes what differs from the defaults into a file.
PELAGE_C_API pelage_result pelage_settings_save(pelage_settings* settings, const char* path);
/// Sets a parameter. \param numbers  one; three of a vector or color, eight of a curve. A choice is
/// its index, counts are exact up to 2^53.
PELAGE_C_API pelage_result pelage_settings_set(pelage_settings* settings, const char* name,
                                               const double* numbers, uint32_t count);
/// Reads a parameter. \param count  its numbers, for which `numbers` needs the room.
PELAGE_C_API pelage_result pelage_settings_get(pelage_settings* settings, const char* name,
                                               double* numbers, uint32_t count);

typedef enum pelage_parameter_type {
  PELAGE_PARAMETER_BOOL = 0,
  PELAGE_PARAMETER_COUNT = 1,
  PELAGE_PARAMETER_FLOAT = 2,
  PELAGE_PARAMETER_VECTOR = 3,
  PELAGE_PARAMETER_COLOR = 4,
  PELAGE_PARAMETER_CURVE = 5,
  PELAGE_PARAMETER_CHOICE = 6
} pelage_parameter_type;

/// A row of the table: Parameter (settings/parameter.h). Texts live as long as the program.
typedef struct pelage_parameter {
  uint32_t struct_size;
  uint32_t type;        ///< pelage_parameter_type
  const char* name;     ///< for pelage_settings_set(); of lights that of the first one
  const char* unit;     ///< empty without one
  const char* range;    ///< in words; empty where all values are valid
  const char* meaning;  ///< plain text
  const char* const* choices;
  uint32_t choice_count;
  uint32_t number_count;  ///< 1, 3 or 8
  double low, high;
  double slider_low, slider_high;
  double default_numbers[8];
} pelage_parameter;
PELAGE_C_API pelage_result pelage_parameter_init(pelage_parameter* parameter, size_t size);
PELAGE_C_API uint32_t pelage_parameter_count(void);
PELAGE_C_API pelage_result pelage_parameter_get(uint32_t index, pelage_parameter* parameter);

// Scenes (scene.h, hair_object.h, sdf_collider.h, skeleton_pose.h).

typedef struct pelage_hair_def {
  uint32_t struct_size;
  const char* name;
  /// Its members simulation, material, object, creation and follow; NULL: the defaults. With
  /// "follow.countPerGuide" above 0, follow hairs are generated.
  pelage_settings* settings;
  const pelage_influences* influences;  ///< [guide]; NULL: the asset's, if it has any
  uint32_t influence_count;
  uint32_t bone_count;  ///< 0: as many as the influences need
  pelage_id skeleton;   ///< to follow in place of bones of its own; 0: none
  /// Texels of HairDef::baseTexture: [y][x] linear RGBA; NULL: none.
  const float* base_texture;
  uint32_t base_texture_width, base_texture_height;
} pelage_hair_def;
PELAGE_C_API pelage_result pelage_hair_def_init(pelage_hair_def* def, size_t size);

typedef struct pelage_hair_info {
  uint32_t struct_size;
  uint32_t guide_count, follow_count;
  uint32_t vertices_per_strand;
  uint32_t bone_count;
  pelage_buffer_id positions;  ///< HairBuffers::positions: [strand][vertex] of 4 floats
  pelage_buffer_id tangents;
} pelage_hair_info;
PELAGE_C_API pelage_result pelage_hair_info_init(pelage_hair_info* info, size_t size);

/// SdfColliderDef.
typedef struct pelage_collider_def {
  uint32_t struct_size;
  const char* name;
  pelage_settings* settings;  ///< its members collider and creation.skinning; NULL: the defaults
  float cell_size;
  float band;
  float motion_tolerance;
  uint32_t bone_count;  ///< 0: as many as the mesh needs
  pelage_id skeleton;
  uint64_t memory_cap;
} pelage_collider_def;
PELAGE_C_API pelage_result pelage_collider_def_init(pelage_collider_def* def, size_t size);

/// CapsuleCollider.
typedef struct pelage_capsule {
  float head[3];
  float head_radius;
  float tail[3];
  float tail_radius;
  float friction;
  float angular_velocity[3];
} pelage_capsule;

PELAGE_C_API pelage_result pelage_scene_create(pelage_scene** scene);
/// \param def  NULL: the defaults, also below.
PELAGE_C_API pelage_result pelage_scene_add_hair(pelage_scene* scene, pelage_asset* asset,
                                                 const pelage_hair_def* def, pelage_id* hair);
PELAGE_C_API pelage_result pelage_scene_add_collider(pelage_scene* scene, pelage_mesh* mesh,
                                                     const pelage_collider_def* def,
                                                     pelage_id* collider);
PELAGE_C_API pelage_result pelage_scene_add_skeleton(pelage_scene* scene, const char* name,
                                                     uint32_t bone_count, pelage_id* skeleton);
/// Removes hair, a collider or a skeleton.
PELAGE_C_API pelage_result pelage_scene_remove(pelage_scene* scene, pelage_id id);
/// Sets what may change at any time: of hair the members simulation, material and object, of a
/// collider `collider`.
PELAGE_C_API pelage_result pelage_scene_set_settings(pelage_scene* scene, pelage_id id,
                                                     pelage_settings* settings);
/// setBones() of hair, a collider or a skeleton. \param count  its bone count.
PELAGE_C_API pelage_result pelage_scene_set_bones(pelage_scene* scene, pelage_id id,
                                                  const pelage_transform* bones, uint32_t count);
/// HairObject::setColliders().
PELAGE_C_API pelage_result pelage_scene_set_capsules(pelage_scene* scene, pelage_id hair,
                                                     const pelage_capsule* capsules,
                                                     uint32_t count);
/// HairObject::setMeshColliders(). \param colliders  NULL: all, the default.
PELAGE_C_API pelage_result pelage_scene_set_mesh_colliders(pelage_scene* scene, pelage_id hair,
                                                           const pelage_id* colliders,
                                                           uint32_t count);
/// HairObject::setForces().
PELAGE_C_API pelage_result pelage_scene_set_forces(pelage_scene* scene, pelage_id hair,
                                                   pelage_buffer_id forces);
/// reset() of hair or a collider.
PELAGE_C_API pelage_result pelage_scene_reset(pelage_scene* scene, pelage_id id);
PELAGE_C_API pelage_result pelage_scene_teleport(pelage_scene* scene, pelage_id hair,
                                                 const pelage_transform* motion);
PELAGE_C_API pelage_result pelage_scene_shift_origin(pelage_scene* scene, const float shift[3]);
PELAGE_C_API pelage_result pelage_scene_get_hair_info(pelage_scene* scene, pelage_id hair,
                                                      pelage_hair_info* info);
/// Scene::setTier() to that of a runtime or a headless device, whose handle it takes.
PELAGE_C_API pelage_result pelage_scene_set_tier_of(pelage_scene* scene, void* runtime);

/// A buffer of yours in Scene::resources(), for forces or depth. \param size  in bytes, a multiple
/// of 4. \param bytes  NULL: zeros.
PELAGE_C_API pelage_result pelage_scene_add_buffer(pelage_scene* scene, const char* name,
                                                   uint64_t size, const void* bytes,
                                                   pelage_buffer_id* buffer);
/// Only those of pelage_scene_add_buffer().
PELAGE_C_API pelage_result pelage_scene_remove_buffer(pelage_scene* scene, pelage_buffer_id buffer);

/// Reads all of a buffer back: pelage_read(), or a copy of your own. \return an error ends the call
/// with it.
typedef pelage_result (*pelage_reader)(void* user, pelage_buffer_id buffer, void* bytes,
                                       uint64_t size);
/// Scene::takeSnapshot().
PELAGE_C_API pelage_result pelage_scene_take_snapshot(pelage_scene* scene, pelage_reader reader,
                                                      void* user, pelage_snapshot** snapshot);
/// Scene::recover(). \param snapshot  NULL: all hair is reset. \param kept  objects that go on; may
/// be NULL.
PELAGE_C_API pelage_result pelage_scene_recover(pelage_scene* scene, pelage_snapshot* snapshot,
                                                uint32_t* kept);

// Frames (frame.h, view.h).

typedef struct pelage_view {
  uint32_t struct_size;
  float world_to_clip[4][4];  ///< rows
  float eye[3];
  uint32_t x, y;
  uint32_t width, height;
  uint32_t samples;
  uint32_t reversed_depth;
  uint32_t seed;
  pelage_buffer_id opaque_depth;  ///< TransparencySettings::opaqueDepth
} pelage_view;
PELAGE_C_API pelage_result pelage_view_init(pelage_view* view, size_t size);
/// lookAt(): sets world_to_clip and eye, for the view's width, height and reversed_depth.
PELAGE_C_API pelage_result pelage_view_look_at(pelage_view* view, const float eye[3],
                                               const float target[3], const float up[3],
                                               float vertical_fov, float near_plane,
                                               float far_plane);

/// Scene::simulate(): begins a frame. Give it to a runtime, then destroy it.
PELAGE_C_API pelage_result pelage_scene_simulate(pelage_scene* scene, float dt,
                                                 pelage_frame** frame);
PELAGE_C_API pelage_result pelage_frame_interpolate(pelage_frame* frame, float share);
/// Frame::draw(). \param settings  its members lights and transparency; NULL: the defaults.
/// \param number  of the view: 0, 1, ...; may be NULL.
PELAGE_C_API pelage_result pelage_frame_draw(pelage_frame* frame, const pelage_view* view,
                                             pelage_settings* settings, uint32_t* number);

// Vulkan (vulkan.h): not in libraries that were built without PELAGE_VULKAN. VkInstance,
// VkPhysicalDevice, VkDevice and VkCommandBuffer are pointers; handles that Vulkan calls
// non-dispatchable are their 64 bits; enums are numbers.

/// Any function; cast vkGetInstanceProcAddr to it.
typedef void (*pelage_function)(void);

typedef struct pelage_vulkan_runtime_def {
  uint32_t struct_size;
  uint32_t queue_family;
  void* instance;
  void* physical_device;
  void* device;
  const void* enabled_features;  ///< const VkPhysicalDeviceFeatures*; NULL: none
  pelage_function get_instance_proc_addr;
  const void* allocation_callbacks;  ///< const VkAllocationCallbacks*; it outlives the runtime
  uint64_t pipeline_cache;           ///< VkPipelineCache; 0: one of the runtime's own
  uint32_t debug_utils;
  uint32_t pipeline_threads;
  uint32_t max_frames_in_flight;
} pelage_vulkan_runtime_def;
PELAGE_C_API pelage_result pelage_vulkan_runtime_def_init(pelage_vulkan_runtime_def* def,
                                                          size_t size);

/// vulkan::ViewTarget with its TargetFormats.
typedef struct pelage_vulkan_target {
  uint32_t struct_size;
  uint32_t color, depth, stencil;  ///< VkFormat
  uint32_t samples;
  uint32_t subpass;
  uint64_t render_pass;  ///< VkRenderPass; 0: dynamic rendering
  uint32_t other_color_count;
  uint32_t other_colors[7];  ///< VkFormat
  int32_t x, y;
  uint32_t width, height;
  /// Begin and end your render pass; both are needed. The first list of a view may clear.
  void (*begin)(void* user, uint32_t view, uint32_t list_of_view);
  void (*end)(void* user, uint32_t view, uint32_t list_of_view);
  void* user;
} pelage_vulkan_target;
PELAGE_C_API pelage_result pelage_vulkan_target_init(pelage_vulkan_target* target, size_t size);

PELAGE_C_API pelage_result pelage_vulkan_runtime_create(const pelage_vulkan_runtime_def* def,
                                                        pelage_vulkan_runtime** runtime);
PELAGE_C_API pelage_result pelage_vulkan_begin_frame(pelage_vulkan_runtime* runtime, uint64_t frame,
                                                     uint64_t completed_frame);
/// Runtime::record() of a frame. \param commands  VkCommandBuffer. \param targets  one a view.
PELAGE_C_API pelage_result pelage_vulkan_record(pelage_vulkan_runtime* runtime, pelage_frame* frame,
                                                void* commands, const pelage_vulkan_target* targets,
                                                uint32_t target_count);
PELAGE_C_API pelage_result pelage_vulkan_submitted(pelage_vulkan_runtime* runtime);
PELAGE_C_API pelage_result pelage_vulkan_abandon_frame(pelage_vulkan_runtime* runtime);
PELAGE_C_API pelage_result pelage_vulkan_collect(pelage_vulkan_runtime* runtime,
                                                 uint64_t completed_frame);
/// Runtime::registerBuffer(). \param vk_buffer  VkBuffer, with room behind `offset`.
PELAGE_C_API pelage_result pelage_vulkan_register_buffer(pelage_vulkan_runtime* runtime,
                                                         pelage_buffer_id buffer,
                                                         uint64_t vk_buffer, uint64_t offset);
/// Runtime::buffer(): where a buffer is. \param vk_buffer  VkBuffer.
PELAGE_C_API pelage_result pelage_vulkan_buffer(pelage_vulkan_runtime* runtime,
                                                pelage_buffer_id buffer, uint64_t* vk_buffer,
                                                uint64_t* offset, uint64_t* size);

// OpenGL and OpenGL ES (gl.h): not in libraries that were built without PELAGE_GL. The context of
// pelage_gl_runtime_create() is current in every call, also of pelage_destroy().

typedef struct pelage_gl_runtime_def {
  uint32_t struct_size;
  uint32_t debug;
  pelage_function (*get_proc_address)(const char* name);  ///< eglGetProcAddress, say
  const char* program_cache;  ///< folder for directoryProgramCache(); NULL: none
} pelage_gl_runtime_def;
PELAGE_C_API pelage_result pelage_gl_runtime_def_init(pelage_gl_runtime_def* def, size_t size);

/// gl::ViewTarget.
typedef struct pelage_gl_target {
  uint32_t struct_size;
  uint32_t x, y;
  uint32_t width, height;
  /// Binds the framebuffer; the first list of a view may clear it.
  void (*begin)(void* user, uint32_t view, uint32_t list_of_view);
  void* user;
} pelage_gl_target;
PELAGE_C_API pelage_result pelage_gl_target_init(pelage_gl_target* target, size_t size);

PELAGE_C_API pelage_result pelage_gl_runtime_create(const pelage_gl_runtime_def* def,
                                                    pelage_gl_runtime** runtime);
/// Runtime::record() of a frame. \param targets  one a view. \param restore_state  1: the GL state
/// is afterwards as before (StateGuard).
PELAGE_C_API pelage_result pelage_gl_record(pelage_gl_runtime* runtime, pelage_frame* frame,
                                            const pelage_gl_target* targets, uint32_t target_count,
                                            uint32_t restore_state);
PELAGE_C_API pelage_result pelage_gl_register_buffer(pelage_gl_runtime* runtime,
                                                     pelage_buffer_id buffer, uint32_t gl_name);
PELAGE_C_API pelage_result pelage_gl_buffer(pelage_gl_runtime* runtime, pelage_buffer_id buffer,
                                            uint32_t* gl_name);

// Devices without a window (headless.h).

typedef enum pelage_api { PELAGE_VULKAN = 0, PELAGE_GL = 1, PELAGE_GLES = 2 } pelage_api;

typedef struct pelage_headless_def {
  uint32_t struct_size;
  uint32_t api;  ///< pelage_api
  uint32_t validation;
  int32_t device_index;
} pelage_headless_def;
PELAGE_C_API pelage_result pelage_headless_def_init(pelage_headless_def* def, size_t size);

/// RenderTargetDef, and where the picture goes.
typedef struct pelage_headless_target {
  uint32_t struct_size;
  uint32_t width, height;
  uint32_t samples;
  float clear_color[4];
  float clear_depth;
  uint32_t x, y;  ///< the viewport
  uint32_t area_width, area_height;
  float* pixels;  ///< width * height * 4 floats: linear RGBA, row 0 is the top row
} pelage_headless_target;
PELAGE_C_API pelage_result pelage_headless_target_init(pelage_headless_target* target, size_t size);

/// \param def  NULL: Vulkan, on the best device.
PELAGE_C_API pelage_result pelage_headless_create(const pelage_headless_def* def,
                                                  pelage_headless** device);
/// Name of the GPU; lives as long as the device.
PELAGE_C_API pelage_result pelage_headless_get_name(pelage_headless* device, const char** name);
/// Runs a frame and waits. \param targets  one a view; none where the frame has none.
PELAGE_C_API pelage_result pelage_headless_run(pelage_headless* device, pelage_frame* frame,
                                               const pelage_headless_target* targets,
                                               uint32_t target_count);

/// Waits for the GPU and reads a part of a buffer. \param runtime  a pelage_headless or a
/// pelage_gl_runtime; with Vulkan, copy from pelage_vulkan_buffer().
PELAGE_C_API pelage_result pelage_read(void* runtime, pelage_buffer_id buffer, uint64_t offset,
                                       void* bytes, uint64_t size);

#ifdef __cplusplus
}
#endif

// NOLINTEND(readability-identifier-naming, modernize-*)
