// A vertex into the picture, and into the shadow map where there is light.
// LIT, COLORED, TEXTURED are defined for surfaces that are so.

uniform mat4 clip_from_world;
in vec3 in_position;

#ifdef LIT
uniform mat4 light_from_world;
in vec3 in_normal;
out vec3 world_position;
out vec3 normal;
out vec3 place_in_light;
#endif
#ifdef COLORED
in vec3 in_color;
out vec3 color;
#endif
#ifdef TEXTURED
in vec2 in_texture;
out vec2 place_in_texture;
#endif

void main()
{
    gl_Position = clip_from_world * vec4(in_position, 1.0);
#ifdef LIT
    world_position = in_position;
    normal = in_normal;
    place_in_light = (light_from_world * vec4(in_position, 1.0)).xyz * 0.5 + 0.5;
#endif
#ifdef COLORED
    color = in_color;
#endif
#ifdef TEXTURED
    place_in_texture = in_texture;
#endif
}
