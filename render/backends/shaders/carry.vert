// A vertex and its normal carried by its joints, into the world. CARRY names the generated function
// that stands above, ROWS the rows of four numbers in an entry of the palette. Where SIGNED is
// defined, an entry and its negative mean the same motion, and all take the sign of the first; MORE
// says that a vertex may follow eight joints.

uniform sampler2D palette;
uniform mat4 world_from_character;
in vec3 in_position;
in vec3 in_normal;
in uvec4 in_joints;
in vec4 in_weights;
#ifdef MORE
in uvec4 in_more_joints;
in vec4 in_more_weights;
#endif
out vec3 position;
out vec3 normal;

void main()
{
    vec4 total[ROWS];
    vec4 first = texelFetch(palette, ivec2(0, int(in_joints[0])), 0);
    for (int row = 0; row < ROWS; ++row) {
        total[row] = vec4(0.0);
    }
#ifdef MORE
    for (int k = 0; k < 8; ++k) {
        int joint = int(k < 4 ? in_joints[k] : in_more_joints[k - 4]);
        float share = k < 4 ? in_weights[k] : in_more_weights[k - 4];
#else
    for (int k = 0; k < 4; ++k) {
        int joint = int(in_joints[k]);
        float share = in_weights[k];
#endif
#ifdef SIGNED
        if (dot(first, texelFetch(palette, ivec2(0, joint), 0)) < 0.0) {
            share = -share;
        }
#endif
        for (int row = 0; row < ROWS; ++row) {
            total[row] += share * texelFetch(palette, ivec2(row, joint), 0);
        }
    }
    float entry[4 * ROWS];
    for (int row = 0; row < ROWS; ++row) {
        entry[4 * row] = total[row].x;
        entry[4 * row + 1] = total[row].y;
        entry[4 * row + 2] = total[row].z;
        entry[4 * row + 3] = total[row].w;
    }
    float point[3] = float[3](in_position.x, in_position.y, in_position.z);
    float direction[3] = float[3](in_normal.x, in_normal.y, in_normal.z);
    float carried[6];
    CARRY(entry, point, direction, carried);
    position = (world_from_character * vec4(carried[0], carried[1], carried[2], 1.0)).xyz;
    normal = normalize(mat3(world_from_character) * vec3(carried[3], carried[4], carried[5]));
}
