// First pass of the sort: how many elements each bucket has.
precision highp float;
precision highp int;

#include "reflections/sort.glsl"

void main() {
    uint element = gl_GlobalInvocationID.x;
    if (element < elements) {
        atomicAdd(buckets[bucketOf(element)], 1u);
    }
}
