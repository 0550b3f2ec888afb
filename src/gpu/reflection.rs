//! What naga sees of a shader, for tests: modules are valid, and their structs lie in memory as Rust writes them.

use super::shader::{evaluate_source, frame_source, picture_source, realize_source, rivals_source};
use encase::ShaderType;
use encase::private::StructMetadata;

/// Every module, with its entry points.
fn modules() -> [(naga::Module, &'static str, usize); 5] {
    [
        (evaluate_source(), 3),
        (picture_source(), 2),
        (frame_source(), 13),
        (realize_source(), 2),
        (rivals_source(), 15),
    ]
    .map(|(source, entries)| {
        let module = naga::front::wgsl::parse_str(source).unwrap_or_else(|e| {
            let text = e.emit_to_string(source);
            unreachable!("{text}")
        });
        (module, source, entries)
    })
}

#[test]
fn modules_are_valid() {
    let flags = naga::valid::ValidationFlags::all();
    for (module, source, entries) in modules() {
        let mut validator =
            naga::valid::Validator::new(flags, naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32);
        if let Err(e) = validator.validate(&module) {
            unreachable!("{}", e.emit_to_string(source));
        }
        assert_eq!(module.entry_points.len(), entries);
    }
}

/// Asserts that the WGSL struct of this name has the size and the offsets with which `T` is written.
pub(super) fn assert_same_layout<T, const N: usize>(name: &str)
where
    T: ShaderType<ExtraMetadata = StructMetadata<N>>,
{
    let modules = modules();
    let mut types = modules.iter().flat_map(|(module, ..)| module.types.iter());
    let found = types.find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
        unreachable!("no struct {name}");
    };
    let offsets: Vec<u64> = members.iter().map(|m| u64::from(m.offset)).collect();
    assert_eq!(offsets, T::METADATA.extra.offsets, "{name}");
    assert_eq!(u64::from(*span), T::min_size().get(), "{name}");
}
