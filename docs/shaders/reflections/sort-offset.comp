// Second pass of the sort: where each bucket begins, and the size of its dispatch.
precision highp float;
precision highp int;

layout(local_size_x = 64) in;

layout(std430, binding = 8) buffer Buckets {
    uint total;
    uint buckets[];
};

layout(std430, binding = 9) buffer Arguments {
    uvec4 arguments[];
};

uniform uint bucketCount;

void main() {
    uint bucket = gl_GlobalInvocationID.x;
    if (bucket < bucketCount) {
        uint size = buckets[bucket];
        arguments[bucket] = uvec4((size + 63u) / 64u, 1u, 1u, size);
        buckets[bucket] = atomicAdd(total, size);
    }
}
