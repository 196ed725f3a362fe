// Loads a mesh file by assimp and makes a collision mesh of it, linked as pkg-config says:
// authoring FILE. It exits with 0 when the file has one triangle, and so does the collision mesh.
#include <pelage/authoring/collision_from_mesh.h>

#include <cstdio>

int main(int argc, char** argv) {
  const auto mesh = pelage::loadSkinnedMesh(argc > 1 ? argv[1] : "");
  if (!mesh) return std::fprintf(stderr, "authoring: %s\n", mesh.error().message.c_str()), 1;
  const auto made = pelage::collisionMeshes(*mesh, {.errorBound = 0.01f});
  if (!made) return std::fprintf(stderr, "authoring: %s\n", made.error().message.c_str()), 1;
  const uint32_t triangles = made->front().sourceTriangleCount;
  std::printf("authoring: %u and %u triangles\n", mesh->triangleCount(), triangles);
  return mesh->triangleCount() == 1 && triangles == 1 ? 0 : 1;
}
