// A vertex with its texture coordinates into the image; its place and normal stay in the world.

uniform mat4 clip_from_world;
in vec3 in_position;
in vec3 in_normal;
out vec3 world_position;
out vec3 world_normal;
#ifdef COLORED
in vec4 in_color;
out vec4 color;
#endif
#ifdef FIRST_SET
in vec2 in_first;
out vec2 first_place;
#endif
#ifdef SECOND_SET
in vec2 in_second;
out vec2 second_place;
#endif

void main()
{
    gl_Position = clip_from_world * vec4(in_position, 1.0);
    world_position = in_position;
    world_normal = in_normal;
#ifdef COLORED
    color = in_color;
#endif
#ifdef FIRST_SET
    first_place = in_first;
#endif
#ifdef SECOND_SET
    second_place = in_second;
#endif
}
