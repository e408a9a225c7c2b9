// Last pass of the sort: each element's number into its bucket's stretch.
precision highp float;
precision highp int;

#include "reflections/sort.glsl"

void main() {
    uint element = gl_GlobalInvocationID.x;
    if (element < elements) {
        uint place = atomicAdd(buckets[bucketOf(element)], 1u);
        order[place] = element;
    }
}
