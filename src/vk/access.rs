//! Table of accesses: stages, memory accesses and image layout of each use of a resource. Every barrier is made from
//! two of its rows.

use ash::vk;

/// Use of a resource by a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// No use yet; contents are undefined.
    Nothing,
    /// Destination of a copy.
    TransferWrite,
    /// Source of a copy.
    TransferRead,
    /// Colour attachment that is drawn into.
    ColorAttachment,
    /// Depth attachment that is tested and written, with the stencil if the format has one.
    DepthAttachment,
    /// Texture or buffer that vertex, fragment or compute shaders read.
    ShaderRead,
    /// Buffer that a compute shader writes.
    ComputeWrite,
    /// Vertices and indices.
    VertexRead,
    /// Buffer that the host reads after the work is done.
    HostRead,
    /// Image that a window shows.
    Present,
}

impl Access {
    /// Returns stages, memory accesses and the image layout of this use.
    pub fn row(self) -> (vk::PipelineStageFlags2, vk::AccessFlags2, vk::ImageLayout) {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        match self {
            Self::Nothing => (S::NONE, A::NONE, L::UNDEFINED),
            Self::TransferWrite => (S::COPY, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL),
            Self::TransferRead => (S::COPY, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL),
            Self::ColorAttachment => (
                S::COLOR_ATTACHMENT_OUTPUT,
                A::COLOR_ATTACHMENT_WRITE | A::COLOR_ATTACHMENT_READ,
                L::COLOR_ATTACHMENT_OPTIMAL,
            ),
            Self::DepthAttachment => (
                S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
                A::DEPTH_STENCIL_ATTACHMENT_WRITE | A::DEPTH_STENCIL_ATTACHMENT_READ,
                L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
            ),
            Self::ShaderRead => (
                S::VERTEX_SHADER | S::FRAGMENT_SHADER | S::COMPUTE_SHADER,
                A::SHADER_READ | A::UNIFORM_READ,
                L::SHADER_READ_ONLY_OPTIMAL,
            ),
            Self::ComputeWrite => (S::COMPUTE_SHADER, A::SHADER_STORAGE_WRITE, L::GENERAL),
            Self::VertexRead => (
                S::VERTEX_ATTRIBUTE_INPUT | S::INDEX_INPUT,
                A::VERTEX_ATTRIBUTE_READ | A::INDEX_READ,
                L::UNDEFINED,
            ),
            Self::HostRead => (S::HOST, A::HOST_READ, L::GENERAL),
            // Presentation waits for a semaphore, which is signalled when all work is done.
            Self::Present => (S::NONE, A::NONE, L::PRESENT_SRC_KHR),
        }
    }

    /// Returns a barrier over all memory from this use to `next`.
    pub fn memory_barrier(self, next: Self) -> vk::MemoryBarrier2<'static> {
        let ((src_stage, src_access, _), (dst_stage, dst_access, _)) = (self.row(), next.row());
        vk::MemoryBarrier2::default()
            .src_stage_mask(src_stage)
            .src_access_mask(src_access)
            .dst_stage_mask(dst_stage)
            .dst_access_mask(dst_access)
    }

    /// Returns a barrier on `image` from this use to `next`, with the change of layout. From [`Access::Nothing`] the
    /// contents are discarded, but the stages of `next` still wait for earlier work of the same stages on the image.
    pub fn image_barrier(
        self,
        next: Self,
        image: vk::Image,
        range: vk::ImageSubresourceRange,
    ) -> vk::ImageMemoryBarrier2<'static> {
        let ((mut src_stage, mut src_access, old), (dst_stage, dst_access, new)) = (self.row(), next.row());
        if self == Self::Nothing {
            (src_stage, src_access) = (dst_stage, vk::AccessFlags2::NONE);
        }
        // Images are never uniform buffers.
        let of_image = |access: vk::AccessFlags2| access & !vk::AccessFlags2::UNIFORM_READ;
        vk::ImageMemoryBarrier2::default()
            .src_stage_mask(src_stage)
            .src_access_mask(of_image(src_access))
            .dst_stage_mask(dst_stage)
            .dst_access_mask(of_image(dst_access))
            .old_layout(old)
            .new_layout(new)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image)
            .subresource_range(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

    /// Requirements of a use in the Vulkan specification, written down without [`Access::row`]: the stages that access
    /// the memory (chapter "Supported Access Types"), their reads and writes, and the valid image layouts.
    struct Use {
        access: Access,
        stages: &'static [S],
        reads: &'static [A],
        writes: &'static [A],
        layouts: &'static [L],
        /// True if images are used so; vertices and indices are in buffers.
        of_images: bool,
    }

    const USES: [Use; 9] = [
        Use {
            access: Access::TransferWrite,
            stages: &[S::COPY],
            reads: &[],
            writes: &[A::TRANSFER_WRITE],
            layouts: &[L::TRANSFER_DST_OPTIMAL, L::GENERAL],
            of_images: true,
        },
        Use {
            access: Access::TransferRead,
            stages: &[S::COPY],
            reads: &[A::TRANSFER_READ],
            writes: &[],
            layouts: &[L::TRANSFER_SRC_OPTIMAL, L::GENERAL],
            of_images: true,
        },
        Use {
            access: Access::ColorAttachment,
            stages: &[S::COLOR_ATTACHMENT_OUTPUT],
            // Blending and loading read.
            reads: &[A::COLOR_ATTACHMENT_READ],
            writes: &[A::COLOR_ATTACHMENT_WRITE],
            layouts: &[L::COLOR_ATTACHMENT_OPTIMAL, L::ATTACHMENT_OPTIMAL, L::GENERAL],
            of_images: true,
        },
        Use {
            access: Access::DepthAttachment,
            // Loaded and tested early, tested and stored late.
            stages: &[S::EARLY_FRAGMENT_TESTS, S::LATE_FRAGMENT_TESTS],
            reads: &[A::DEPTH_STENCIL_ATTACHMENT_READ],
            writes: &[A::DEPTH_STENCIL_ATTACHMENT_WRITE],
            layouts: &[L::DEPTH_ATTACHMENT_OPTIMAL, L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, L::GENERAL],
            of_images: true,
        },
        Use {
            access: Access::ShaderRead,
            stages: &[S::VERTEX_SHADER, S::FRAGMENT_SHADER, S::COMPUTE_SHADER],
            reads: &[A::SHADER_SAMPLED_READ, A::SHADER_STORAGE_READ],
            writes: &[],
            layouts: &[L::SHADER_READ_ONLY_OPTIMAL, L::READ_ONLY_OPTIMAL, L::GENERAL],
            of_images: true,
        },
        Use {
            access: Access::ComputeWrite,
            stages: &[S::COMPUTE_SHADER],
            reads: &[],
            writes: &[A::SHADER_STORAGE_WRITE],
            layouts: &[L::GENERAL],
            of_images: true,
        },
        Use {
            access: Access::VertexRead,
            stages: &[S::VERTEX_ATTRIBUTE_INPUT, S::INDEX_INPUT],
            reads: &[A::VERTEX_ATTRIBUTE_READ, A::INDEX_READ],
            writes: &[],
            layouts: &[],
            of_images: false,
        },
        Use {
            access: Access::HostRead,
            stages: &[S::HOST],
            reads: &[A::HOST_READ],
            writes: &[],
            layouts: &[L::GENERAL],
            of_images: false,
        },
        // The semaphore of the presentation waits for all work and makes it visible, so that stages and accesses are
        // empty.
        Use {
            access: Access::Present,
            stages: &[],
            reads: &[],
            writes: &[],
            layouts: &[L::PRESENT_SRC_KHR],
            of_images: true,
        },
    ];

    /// Returns true if `mask` contains `stage`, or one that includes it by the specification.
    fn holds_stage(mask: S, stage: S) -> bool {
        let wider = match stage {
            S::COPY => S::ALL_TRANSFER,
            S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS | S::COLOR_ATTACHMENT_OUTPUT => S::ALL_GRAPHICS,
            S::VERTEX_SHADER | S::FRAGMENT_SHADER => S::ALL_GRAPHICS,
            S::VERTEX_ATTRIBUTE_INPUT | S::INDEX_INPUT => S::VERTEX_INPUT,
            // ALL_COMMANDS has no host.
            S::HOST => return mask.contains(S::HOST),
            _ => S::ALL_COMMANDS,
        };
        mask.intersects(stage | wider | S::ALL_COMMANDS)
    }

    /// Returns true if `mask` contains `access`, or one that includes it by the specification.
    fn holds_access(mask: A, access: A) -> bool {
        let wider = match access {
            A::SHADER_SAMPLED_READ | A::SHADER_STORAGE_READ => A::SHADER_READ | A::MEMORY_READ,
            A::SHADER_STORAGE_WRITE => A::SHADER_WRITE | A::MEMORY_WRITE,
            read if format!("{read:?}").contains("READ") => A::MEMORY_READ,
            _ => A::MEMORY_WRITE,
        };
        mask.intersects(access | wider)
    }

    /// Asserts that a barrier with these scopes orders `first` before `next` and makes the writes of `first` visible to
    /// `next`.
    fn assert_orders(first: &Use, next: &Use, scopes: (S, A, S, A), layouts: Option<(L, L)>) {
        let (src_stage, src_access, dst_stage, dst_access) = scopes;
        let what = format!("{:?} then {:?}: {scopes:?} {layouts:?}", first.access, next.access);
        // Execution: all of the first use comes before any of the next, whichever of them writes.
        assert!(first.stages.iter().all(|s| holds_stage(src_stage, *s)), "waits for too little: {what}");
        assert!(next.stages.iter().all(|s| holds_stage(dst_stage, *s)), "too little waits: {what}");
        // Memory: writes are made available, and visible to reads and writes.
        assert!(first.writes.iter().all(|a| holds_access(src_access, *a)), "not available: {what}");
        let mut seen = next.reads.iter().chain(next.writes);
        assert!(seen.all(|a| holds_access(dst_access, *a)), "not visible: {what}");
        if let Some((old, new)) = layouts {
            assert!(first.layouts.contains(&old), "the old layout drops the contents: {what}");
            assert!(next.layouts.contains(&new), "no layout for the next use: {what}");
        }
    }

    fn masks(barrier: &vk::ImageMemoryBarrier2) -> (S, A, S, A) {
        (barrier.src_stage_mask, barrier.src_access_mask, barrier.dst_stage_mask, barrier.dst_access_mask)
    }

    #[test]
    fn every_barrier_between_two_uses_does_what_the_specification_asks_for() {
        for first in &USES {
            for next in &USES {
                let of_memory = first.access.memory_barrier(next.access);
                let scopes = (
                    of_memory.src_stage_mask,
                    of_memory.src_access_mask,
                    of_memory.dst_stage_mask,
                    of_memory.dst_access_mask,
                );
                assert_orders(first, next, scopes, None);
                if first.of_images && next.of_images {
                    let range = vk::ImageSubresourceRange::default();
                    let barrier = first.access.image_barrier(next.access, vk::Image::null(), range);
                    assert_orders(
                        first,
                        next,
                        masks(&barrier),
                        Some((barrier.old_layout, barrier.new_layout)),
                    );
                }
            }
        }
    }

    #[test]
    fn an_image_whose_contents_are_dropped_still_waits_for_its_earlier_use() {
        for next in USES.iter().filter(|next| next.of_images) {
            let range = vk::ImageSubresourceRange::default();
            let barrier = Access::Nothing.image_barrier(next.access, vk::Image::null(), range);
            let (src_stage, src_access, dst_stage, dst_access) = masks(&barrier);
            assert_eq!((src_access, barrier.old_layout), (A::NONE, L::UNDEFINED));
            assert!(next.layouts.contains(&barrier.new_layout), "{:?}", next.access);
            assert!(next.stages.iter().all(|s| holds_stage(src_stage, *s) && holds_stage(dst_stage, *s)));
            let mut used = next.reads.iter().chain(next.writes);
            assert!(used.all(|a| holds_access(dst_access, *a)), "{:?}", next.access);
        }
    }

    #[test]
    fn barriers_that_lack_a_part_are_noticed() {
        let [write, read] = [&USES[0], &USES[4]];
        let whole = (S::COPY, A::TRANSFER_WRITE, S::ALL_COMMANDS, A::SHADER_READ);
        assert_orders(write, read, whole, Some((L::TRANSFER_DST_OPTIMAL, L::SHADER_READ_ONLY_OPTIMAL)));
        let lacking = [
            (S::NONE, whole.1, whole.2, whole.3),
            (whole.0, A::NONE, whole.2, whole.3),
            (whole.0, whole.1, S::FRAGMENT_SHADER, whole.3),
            (whole.0, whole.1, whole.2, A::NONE),
        ];
        for scopes in lacking {
            let noticed = std::panic::catch_unwind(|| assert_orders(write, read, scopes, None));
            assert!(noticed.is_err(), "{scopes:?}");
        }
    }
}
