// What the traversals of kd-trees and grids share.

// Triangles of the leaves.
layout(std430, binding = 2) readonly buffer References {
    uint references[];
};

uniform vec3 sceneLow;
uniform vec3 sceneHigh;
