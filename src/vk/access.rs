//! The one table of accesses: what a pass does with a resource, as stage, memory access and image layout. Every barrier
//! is made from two of its rows.

use ash::vk;

/// How a resource is used by a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Nothing yet; contents are undefined.
    Nothing,
    /// Copied into.
    TransferWrite,
    /// Copied from.
    TransferRead,
    /// Drawn into as a colour attachment.
    ColorAttachment,
    /// Tested and written as a depth attachment.
    DepthAttachment,
    /// Sampled or read by vertex, fragment or compute shaders.
    ShaderRead,
    /// Written by a compute shader.
    ComputeWrite,
    /// Read as vertices and indices.
    VertexRead,
    /// Read by the host after the work is done.
    HostRead,
    /// Shown in a window.
    Present,
}

impl Access {
    /// Stages, memory accesses and the image layout of this use.
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
                L::DEPTH_ATTACHMENT_OPTIMAL,
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
            // A semaphore, signalled when all is done, stands between this and the display.
            Self::Present => (S::NONE, A::NONE, L::PRESENT_SRC_KHR),
        }
    }

    /// A barrier over all memory from this use to `next`.
    pub fn memory_barrier(self, next: Self) -> vk::MemoryBarrier2<'static> {
        let ((src_stage, src_access, _), (dst_stage, dst_access, _)) = (self.row(), next.row());
        vk::MemoryBarrier2::default()
            .src_stage_mask(src_stage)
            .src_access_mask(src_access)
            .dst_stage_mask(dst_stage)
            .dst_access_mask(dst_access)
    }

    /// A barrier on `image` from this use to `next`, with the change of layout. From [`Access::Nothing`] the contents are
    /// dropped, but `next`'s own stages still wait for each other's earlier work on the image.
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
        // No image is a uniform buffer.
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
